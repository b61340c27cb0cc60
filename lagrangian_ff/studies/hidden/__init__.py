"""Is a hidden effect found in the recordings of its arm, and nothing where nothing is hidden?"""
