"""A capture from what is asked for to its files, stage by stage."""

# What it makes, and how its cameras stand: known without opening any of it.
TO = ("cameras", "neutral", "poses")
RIGS = ("walking", "fixed")
