"""Trained styles and manifolds as they stand in files (`files`)."""
