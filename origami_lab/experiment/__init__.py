"""One experiment: a configuration and its seeds become trials, files on disk, and MLflow runs.

The only layer that knows Hydra and MLflow. It reads a composed configuration (:mod:`.settings`), builds
the game, objective and searcher (:mod:`.build`), runs each seed in a worker process (:mod:`.runner`,
:mod:`.pool`, :mod:`.worker`, :mod:`.trial`), keeps the run folder (:mod:`.folder`) and tells the tracker
(:mod:`.tracking`). :mod:`.api` is the way in from Python, :mod:`.result` the way out.
"""
