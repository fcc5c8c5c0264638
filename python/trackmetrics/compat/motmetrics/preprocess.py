"""MOTChallenge's preprocessing: results on distractors do not count."""

from configparser import ConfigParser
from typing import Any

import numpy as np

from trackmetrics.compat.motmetrics.distances import iou_matrix
from trackmetrics.compat.motmetrics.lap import linear_sum_assignment

DISTRACTORS = (2, 7, 8, 12)
"""Classes of MOTChallenge: person on vehicle, static person, distractor, reflection."""
_BOX = ["X", "Y", "Width", "Height"]


def preprocessResult(res: Any, gt: Any, inifile: Any) -> Any:
    """The results without those that are assigned to a distractor.

    Parameters
    ----------
    res, gt : DataFrame
        Results and truth with their classes, indexed by FrameId and Id.
    inifile : path
        The sequence's seqinfo.ini, which has its number of frames.
    """
    settings = ConfigParser()
    settings.read(inifile, encoding="utf8")
    frames = range(1, int(settings["Sequence"]["seqLength"]) + 1)
    truth = {t: part for t, part in gt.groupby(level=0) if t in frames}
    found = []
    for t, results in res.groupby(level=0):
        if t not in truth:
            continue
        rows, columns = linear_sum_assignment(
            iou_matrix(truth[t][_BOX].to_numpy(), results[_BOX].to_numpy(), max_iou=0.5)
        )
        classes, visibility = truth[t]["ClassId"].to_numpy(), truth[t]["Visibility"].to_numpy()
        dropped = np.isin(classes, DISTRACTORS) | (visibility < 0)
        ids = results.index.get_level_values(1)
        found += [(t, ids[j]) for i, j in zip(rows, columns, strict=True) if dropped[i]]
    return res.drop(labels=found)
