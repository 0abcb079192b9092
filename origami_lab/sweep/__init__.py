"""Sweeps: Optuna studies over the settings of a searcher, declared in one YAML file each (docs/sweeps.md)."""
