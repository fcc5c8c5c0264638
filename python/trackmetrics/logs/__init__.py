"""Logs of estimators: what a filter said at each update, and the truth where it is known."""

from trackmetrics.logs.header import State
from trackmetrics.logs.log import EstimatorLog
from trackmetrics.logs.read import read_log

__all__ = ["EstimatorLog", "State", "read_log"]
