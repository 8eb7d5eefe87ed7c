"""The command line: what it prints, asks and refuses, and how its processes end."""
