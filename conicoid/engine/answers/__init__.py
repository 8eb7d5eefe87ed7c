"""Rays and answers as users hold them."""
