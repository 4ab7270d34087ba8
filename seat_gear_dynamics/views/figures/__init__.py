"""Figures in one style, for print and for screen: arrays in, axes out."""
