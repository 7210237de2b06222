"""Data sets made: by threads, by processes, by machines; tried, and made again to compare."""
