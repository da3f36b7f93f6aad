"""Simulations of a model against a measurement: the statistics that both are compared by, the
draws that models share, and the gap index.
"""
