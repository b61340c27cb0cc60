"""Hidden effects once more, in arms with the nuisances of real ones: right, or silent?"""
