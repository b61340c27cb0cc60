"""The search for missing effects: candidates, their log Bayes factors, and the null."""
