"""Fuzzers of all files that Conicoid reads: cases made from a number, in a process with limits."""
