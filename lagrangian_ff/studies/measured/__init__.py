"""The study of measured recordings: the errors of models, and verdicts on what is known."""
