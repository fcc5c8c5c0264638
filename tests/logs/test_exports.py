"""Logs as other programs export them: each gives the log that was exported, to the bit."""

import io

import numpy as np
import pytest

from trackmetrics._tables import delimited, json_lines, polars_columns, times
from trackmetrics.logs import EstimatorLog, read_log

ROWS = 40
RNG = np.random.default_rng(5)
TIME = 1000.0 + np.arange(ROWS) * 0.1
NIS = RNG.chisquare(2, ROWS)
X = RNG.normal(size=(ROWS, 2))


def use(reader, monkeypatch):
    """Reads by Polars, or by the small readers that do without it."""
    if reader == "small":
        for module in (delimited, json_lines, polars_columns, times):
            monkeypatch.setattr(module, "polars", lambda: None)


def table():
    return {"time": TIME, "nis": NIS, "nis_dof": np.full(ROWS, 2), "x[0]": X[:, 0], "x[1]": X[:, 1]}


def cells(separator=",", decimal="."):
    rows = [
        [repr(float(v)).replace(".", decimal) for v in row]
        for row in zip(*table().values(), strict=True)
    ]
    return [separator.join(row) for row in rows]


def excel():
    """``CSV UTF-8`` of a German Excel: byte order mark, semicolons, decimal commas."""
    return "\r\n".join([";".join(table()), *cells(";", ","), ""]).encode("utf-8-sig")


def excel_with_separator_line():
    return b"sep=;\r\n" + excel().removeprefix(b"\xef\xbb\xbf")


def excel_unicode_text():
    return "\r\n".join(["\t".join(table()), *cells("\t", ","), ""]).encode("utf-16")


def r_write_csv():
    heading = ",".join(['""', *(f'"{name}"' for name in table())])
    rows = [f'"{k + 1}",{row}' for k, row in enumerate(cells())]
    return "\n".join([heading, *rows, ""]).encode()


def r_write_csv2():
    heading = ";".join(['""', *(f'"{name}"' for name in table())])
    rows = [f'"{k + 1}";{row}' for k, row in enumerate(cells(";", ","))]
    return "\n".join([heading, *rows, ""]).encode()


def matlab_writetable():
    return "\n".join([",".join(table()), *cells(), ""]).encode()


def matlab_writetable_tabs():
    return "\r\n".join(["\t".join(table()), *cells("\t"), ""]).encode()


def pandas_with_index():
    pandas = pytest.importorskip("pandas")
    return pandas.DataFrame(table()).to_csv().encode()


def pandas_without_index():
    pandas = pytest.importorskip("pandas")
    return pandas.DataFrame(table()).to_csv(index=False).encode()


def polars_csv():
    polars = pytest.importorskip("polars")
    return polars.DataFrame(table()).write_csv().encode()


def savetxt(delimiter, comments):
    def write():
        out = io.StringIO()
        values = np.column_stack(list(table().values()))
        heading = delimiter.join(table())
        np.savetxt(out, values, fmt="%.18e", delimiter=delimiter, header=heading, comments=comments)
        return out.getvalue().encode()

    return write


def duckdb_copy():
    """``COPY ... TO 'log.csv' (HEADER)``."""
    return "\n".join(
        [",".join(f'"{n}"' if "[" in n else n for n in table()), *cells(), ""]
    ).encode()


EXPORTS = [
    excel,
    excel_with_separator_line,
    excel_unicode_text,
    r_write_csv,
    r_write_csv2,
    matlab_writetable,
    matlab_writetable_tabs,
    pandas_with_index,
    pandas_without_index,
    polars_csv,
    duckdb_copy,
]
SAVETXT = {
    "blanks": savetxt(" ", "# "),
    "commas": savetxt(",", "# "),
    "tabs, no mark": savetxt("\t", ""),
    "commas, percent": savetxt(",", "% "),
}


@pytest.mark.parametrize("reader", ["polars", "small"])
@pytest.mark.parametrize("export", [*EXPORTS, *SAVETXT.values()])
def test_delimited_exports(tmp_path, monkeypatch, export, reader):
    path = tmp_path / "log.csv"
    path.write_bytes(export())
    use(reader, monkeypatch)
    log = read_log(path)
    np.testing.assert_array_equal(log.columns.time, TIME)
    np.testing.assert_array_equal(log.columns.nis, NIS)
    np.testing.assert_array_equal(log.columns.x, X)


@pytest.mark.parametrize(
    ("suffix", "reader"),
    [
        (".parquet", "polars"),
        *((suffix, reader) for suffix in (".csv", ".jsonl") for reader in ("polars", "small")),
    ],
)
def test_our_own_files_give_every_bit_back(tmp_path, monkeypatch, suffix, reader):
    use(reader, monkeypatch)
    b = RNG.normal(size=(ROWS, 3, 3))
    p = b @ b.swapaxes(1, 2) + np.eye(3)
    p = (p + p.swapaxes(1, 2)) / 2
    p[3:6, 2], p[3:6, :, 2] = np.nan, np.nan
    innovation = RNG.normal(size=(ROWS, 2)) * 10.0 ** RNG.integers(-300, 300, (ROWS, 2))
    innovation[::3, 1] = np.nan
    given = {
        "track": np.repeat(["a", 'b, "c"\u00e9'], ROWS // 2),
        "time": TIME,
        "x": RNG.normal(size=(ROWS, 3)),
        "P": p,
        "truth": RNG.normal(size=(ROWS, 3)),
        "innovation": innovation,
        "S": np.tile(np.eye(2), (ROWS, 1, 1)) * 1e300,
        "status": [None, "active"] * (ROWS // 2),
    }
    log = EstimatorLog.from_columns(**given)
    log.write(tmp_path / f"log{suffix}")
    again = read_log(tmp_path / f"log{suffix}")
    assert again.tracks == log.tracks
    assert again.columns.status.tolist() == log.columns.status.tolist()
    for name in ("time", "x", "P", "truth", "innovation", "nis", "nees", "nis_dof"):
        np.testing.assert_array_equal(
            getattr(again.columns, name), getattr(log.columns, name), name
        )
    np.testing.assert_array_equal(
        again.columns.S.diagonal(axis1=1, axis2=2)[:, 0], log.columns.S[:, 0, 0]
    )


@pytest.mark.parametrize("library", ["pandas", "polars", "pyarrow"])
def test_parquet_of_other_programs(tmp_path, library):
    module = pytest.importorskip(library)
    path = tmp_path / "log.parquet"
    if library == "pandas":
        module.DataFrame(table()).to_parquet(path)
    elif library == "polars":
        module.DataFrame(table()).write_parquet(path)
    else:
        from pyarrow import parquet

        parquet.write_table(module.table(table()), path)
    log = read_log(path)
    np.testing.assert_array_equal(log.columns.nis, NIS)
    np.testing.assert_array_equal(log.columns.x, X)


@pytest.mark.parametrize("form", ["lines", "array"])
def test_json_of_pandas(tmp_path, form):
    pandas = pytest.importorskip("pandas")
    path = tmp_path / "log.json"
    frame = pandas.DataFrame(table())
    frame.to_json(path, orient="records", lines=form == "lines", double_precision=15)
    np.testing.assert_allclose(read_log(path).columns.nis, NIS, rtol=0, atol=1e-14)


def test_without_polars_the_extra_is_named(tmp_path, monkeypatch):
    from trackmetrics.logs import parquet, read

    path = tmp_path / "log.csv"
    path.write_bytes(matlab_writetable())
    use("small", monkeypatch)
    monkeypatch.setattr(read, "polars", lambda: None)
    assert not read_log(path).notes
    monkeypatch.setattr(read, "MAX_SMALL_BYTES", 1000)
    assert "trackmetrics[files]" in read_log(path).notes[-1]
    with pytest.raises(ModuleNotFoundError, match=r"Parquet needs Polars: .*trackmetrics\[files\]"):
        parquet.write(tmp_path / "log.parquet", {}, {})


@pytest.mark.parametrize("library", ["polars", "pandas", "pyarrow"])
def test_frames_give_every_bit_back(library):
    pytest.importorskip(library)
    b = RNG.normal(size=(ROWS, 2, 2))
    log = EstimatorLog.from_columns(
        track=np.repeat(["a", "b"], ROWS // 2),
        time=TIME,
        x=X,
        P=b @ b.swapaxes(1, 2) + np.eye(2),
        truth=X + RNG.normal(size=X.shape),
        innovation=[row[: 1 + k % 2] for k, row in enumerate(X)],
        S=[np.eye(1 + k % 2) for k in range(ROWS)],
    )
    again = EstimatorLog.from_frame(log.to_frame(library))
    assert again.tracks == log.tracks
    for name in ("time", "x", "P", "truth", "innovation", "S", "nis", "nees"):
        np.testing.assert_array_equal(
            getattr(again.columns, name), getattr(log.columns, name), name
        )


def test_a_library_that_is_none_is_named():
    log = EstimatorLog.from_columns(nis=[1.0], nis_dof=2)
    with pytest.raises(ValueError, match="library must be one of polars, pandas, pyarrow"):
        log.to_frame("numpy")
