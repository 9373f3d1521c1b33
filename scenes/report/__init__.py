"""The report of a prediction: one page, report.html, that opens offline and holds everything that it shows."""

from scenes.report.contents import ReportContents
from scenes.report.write import REPORT_FILE, write_report

__all__ = ["REPORT_FILE", "ReportContents", "write_report"]
