"""The study of experiments that decide: designed motions, investigations, physics without a name."""
