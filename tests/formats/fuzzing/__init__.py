"""Fuzzers of everything that Conicoid reads from files: cases made from a number, run in a process with limits."""
