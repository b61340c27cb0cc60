"""The words in which the commands present their results."""
