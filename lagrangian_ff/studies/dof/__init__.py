"""What studies of error against the number of joints share: cases, numbers, table and curves."""
