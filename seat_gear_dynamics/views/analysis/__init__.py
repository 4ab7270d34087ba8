"""The report of an analysis: one HTML file that asks no host for anything, its figures and its tables."""

from seat_gear_dynamics.views.analysis.figures import figures
from seat_gear_dynamics.views.analysis.page import page
from seat_gear_dynamics.views.analysis.words import summary, summary_lines

__all__ = ["figures", "page", "summary", "summary_lines"]
