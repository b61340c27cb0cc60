"""What all studies share: independent cases, workers that do them, a folder that keeps them."""
