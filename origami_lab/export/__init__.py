"""Designs as files that other programs open."""
