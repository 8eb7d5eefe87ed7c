"""Turntables: a scene turned about once, as a picture that moves."""
