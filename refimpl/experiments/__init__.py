"""What was measured: every table that the README or the notebooks show has its command here."""
