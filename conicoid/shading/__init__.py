"""What happens to light at a surface: one formula, one file; materials and lights as flat records."""
