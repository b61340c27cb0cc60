from lagrangian_ff.report.page import write_page as write_page
from lagrangian_ff.report.pages.compare import compare_page as compare_page
from lagrangian_ff.report.pages.diagnose import diagnose_page as diagnose_page
from lagrangian_ff.report.pages.history import history_page as history_page
from lagrangian_ff.report.section import Section as Section
from lagrangian_ff.report.tracking import Tracking as Tracking
