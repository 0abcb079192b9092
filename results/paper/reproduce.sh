#!/usr/bin/env bash
# Every run behind this folder's tables and figures, then the report itself. Started again it goes on where it was.
#   results/paper/reproduce.sh [FOLDER FOR THE RUNS]
set -euo pipefail
cd "$(dirname "$0")/../.."
runs=${1:-results/paper_runs}
all=search=rdm,dfts,bfts,mcts,evo
common=(tracking=none resume=true)

targets=+experiment=paper/pyramid,paper/cube,paper/bowl,paper/face
objects=+experiment=paper/bucket,paper/shelf,paper/table,paper/chair
variants=+experiment=paper/bucket_xy,paper/shelf_y,paper/table_xy
published='+experiment=[paper/bowl,paper/as_published],[paper/face,paper/as_published]'

origami-lab -m "$targets" "$all" "output=$runs/targets" "${common[@]}"
origami-lab -m "$objects" "$all" "output=$runs/objects" "${common[@]}"
origami-lab -m "$variants" "$all" "output=$runs/variants" "${common[@]}"
origami-lab -m "$targets" search=evo search.rescale=false "output=$runs/plain_evo" "${common[@]}"
origami-lab -m "$published" "$all" "output=$runs/as_published" "${common[@]}"
