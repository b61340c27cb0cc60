from lagrangian_ff.report.page import Section as Section
from lagrangian_ff.report.page import write_page as write_page
from lagrangian_ff.report.pages import compare_page as compare_page
from lagrangian_ff.report.pages import diagnose_page as diagnose_page
from lagrangian_ff.report.pages import history_page as history_page
from lagrangian_ff.report.pages import investigation_page as investigation_page
from lagrangian_ff.report.sections.tracking import Tracking as Tracking
