"""Designed motions, investigations, and physics without a name: do experiments decide?"""
