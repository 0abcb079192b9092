"""Everyday parts as a person has them in files, and how near a folded sheet comes to them."""
