"""Single samples under the smooth spectrum of their record: how surprising each is, what lies
behind one that is missing, clipped or rounded, and whether a few are thrown off.
"""
