"""Work on workers: real processes and real schedulers."""
