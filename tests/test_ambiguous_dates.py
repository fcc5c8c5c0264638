"""Where day and month cannot be told apart the error shows a row as it is in the file."""

import pytest

from trackmetrics.vessel import read_ais

HEAD = "BaseDateTime,MMSI,LAT,LON,SOG,COG\n"
ROW = "{} 00:0{}:00,111111111,50.0,1.0,10.0,90.0\n"


@pytest.mark.parametrize("dates", [["01/02/2024", "02/02/2024"], ["13/02/2024", "02/14/2024"]])
def test_the_first_row_is_shown(tmp_path, dates):
    path = tmp_path / "ais.csv"
    path.write_text(HEAD + "".join(ROW.format(d, i) for i, d in enumerate(dates)))
    with pytest.raises(ValueError, match="date_order='dmy'") as caught:
        read_ais(path)
    assert f"'{dates[0]} 00:00:00'" in str(caught.value)
