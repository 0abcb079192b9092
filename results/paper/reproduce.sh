#!/usr/bin/env bash
# Every run behind this folder's tables and figures, then the report itself. Started again it goes on where it was.
#   results/paper/reproduce.sh [FOLDER FOR THE RUNS [FOLDER FOR THE REPORT [FOLDER FOR DESIGNS AND FILMS]]]
set -euo pipefail
cd "$(dirname "$0")/../.."
runs=${1:-results/paper_runs}
report=${2:-results/paper/report}
all=search=rdm,dfts,bfts,mcts,evo
others=search=rdm,dfts,bfts,mcts
common=(tracking=none resume=true)

targets=+experiment=paper/pyramid,paper/cube,paper/bowl,paper/face
objects=+experiment=paper/bucket,paper/shelf,paper/table,paper/chair
variants=+experiment=paper/bucket_xy,paper/shelf_y,paper/table_xy
published='+experiment=[paper/bowl,paper/as_published],[paper/face,paper/as_published]'

origami-lab -m "$targets" "$all" "output=$runs/targets" "${common[@]}"
origami-lab -m "$objects" search=evo "output=$runs/objects/evo" "${common[@]}"
origami-lab -m "$variants" search=evo "output=$runs/variants/evo" "${common[@]}"
# the paper's procedure where ours differs
origami-lab -m "$targets" search=evo search.rescale=false "output=$runs/plain_evo" "${common[@]}"
# what its program does, with its way of scoring (conf/program)
origami-lab -m "$published" "$all" "output=$runs/as_published" "${common[@]}"
echo "the paper's own cells without ppo took $((SECONDS / 60)) minutes"
# the objects and variants by the other searchers: the paper has evo only
origami-lab -m "$objects" "$others" "output=$runs/objects/others" "${common[@]}"
origami-lab -m "$variants" "$others" "output=$runs/variants/others" "${common[@]}"
# ppo learns for three to seven minutes a trial, and saves itself: killed, it goes on in the middle
origami-lab -m "$targets" search=ppo "output=$runs/ppo" "${common[@]}"

origami-lab report "$runs" --output "$report" --beside paper
# the best design of each task, and its film
python -m benchmarks.best_designs "$runs/targets" "$runs/objects" "$runs/variants" "$runs/ppo" --out "${3:-results/paper}"
