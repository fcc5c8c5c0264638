"""Recordings of AIS by kind: providers, packing, times, headings, what is not available."""

import gzip
import io
import json
import lzma
import zipfile

import numpy as np
import pytest

from trackmetrics.vessel import Tracker, read_ais, screen_rows

START = 1720562400  # 2024-07-09 22:00:00 UTC
N = 60


def rows(n=N, knots=12.0, step=10.0):
    """A vessel that sails north: (seconds since 1970, latitude, longitude, knots, degrees)."""
    metres = knots * 1852 / 3600 * step
    return [(START + step * k, 55.0 + metres / 111_195 * k, 11.0, knots, 0.0) for k in range(n)]


def text(moment, form):
    date = np.datetime64(round(moment * 1000), "ms").item()
    return date.strftime(form)


def table(time=str, heading="mmsi,time,lat,lon,sog,cog", delimiter=",", decimal="."):
    lines = [heading]
    for moment, *numbers in rows():
        cells = [f"{number:.6f}".replace(".", decimal) for number in numbers]
        if decimal == "," == delimiter:
            cells = [f'"{cell}"' for cell in cells]
        lines.append(delimiter.join(["219000001", time(moment), *cells]))
    return "\n".join(lines) + "\n"


def read(tmp_path, data, name="a.csv", **options):
    file = tmp_path / name
    file.write_bytes(data if isinstance(data, bytes) else data.encode())
    return read_ais(file, **options)


def require_one_vessel(recording, n=N, step=10.0):
    assert recording.rejected == ()
    assert recording.duplicate_mmsi == ()
    assert len(recording.reports) == n
    assert np.allclose(np.diff(recording.reports.time), step, atol=1e-3)
    assert len(recording.reports.vessels) == 1
    assert np.all(np.diff(recording.reports.z[:, 0]) > 0)
    tracker = Tracker()
    tracker.add(recording.reports)
    assert [track.reports for track in tracker.tracks()] == [n]


# ------------------------------------------------------------------ the collected files


@pytest.fixture
def reports(data):
    return data / "reports"


@pytest.mark.data
@pytest.mark.parametrize(
    "name",
    [
        "ais_decimal_comma.csv",
        "ais_gzip.csv.gz",
        "ais_marinecadastre_2025.csv",
        "ais_time_compact.csv",
        "ais_time_go.csv",
        "ais_unix_milliseconds.csv",
    ],
)
def test_collected_files_are_one_vessel_in_steps_of_ten_seconds(reports, name):
    require_one_vessel(read_ais(reports / name))


@pytest.mark.data
def test_the_danish_file(reports):
    recording = read_ais(reports / "ais_danish.csv")
    assert recording.counts == {"base station": 6, "no position": 6}
    assert len(recording.reports) == 72 - 6 - 6
    assert recording.without_course == 0  # only the base stations had none
    assert recording.reports.time[0] == START
    assert recording.out_of_order == 0


@pytest.mark.data
def test_a_date_of_which_day_and_month_cannot_be_told(reports):
    file = reports / "ais_time_month_first.csv"
    with pytest.raises(ValueError, match=r"give date_order='dmy' or date_order='mdy'"):
        read_ais(file)
    require_one_vessel(read_ais(file, date_order="mdy"))
    assert read_ais(file, date_order="mdy").reports.time[0] == START


@pytest.mark.data
def test_a_negative_course_is_not_available(reports):
    recording = read_ais(reports / "ais_negative_course.csv")
    assert recording.rejected == ()
    assert recording.without_course == sum(k == "truncated AIS" for k in recording.reports.kinds)
    assert 0 < recording.without_course < len(recording.reports)


@pytest.mark.data
@pytest.mark.parametrize("name", ["ais_two_reports_one_second.csv", "ais_whole_seconds_31kt.csv"])
def test_stamps_of_whole_seconds(reports, name):
    recording = read_ais(reports / name)
    assert recording.rejected == ()
    assert recording.duplicate_mmsi == ()
    assert recording.time_resolution == 1.0
    tracker = Tracker()
    tracker.add(recording.reports)
    assert len(tracker.tracks()) == 1


# ------------------------------------------------------------------ times


@pytest.mark.parametrize(
    "form",
    [
        lambda t: f"{t:.0f}",
        lambda t: f"{t * 1000:.0f}",
        lambda t: f"{t * 1e6:.0f}",
        lambda t: text(t, "%Y%m%d%H%M%S"),
        lambda t: text(t, "%Y-%m-%dT%H:%M:%S"),
        lambda t: text(t, "%Y-%m-%d %H:%M:%S.375+00:00"),
        lambda t: text(t, "%Y-%m-%dT%H:%M:%SZ"),
        lambda t: text(t, "%Y/%m/%d %H:%M:%S"),
        lambda t: text(t, "%Y-%m-%d %H:%M:%S.375540658 +0000 UTC"),
    ],
)
def test_times_of_every_form(tmp_path, form):
    recording = read(tmp_path, table(form))
    require_one_vessel(recording)
    assert recording.reports.time[0] == pytest.approx(START, abs=0.5)


def test_day_and_month_are_told_by_the_whole_column(tmp_path):
    later = [(t + 86400 * 10, *rest) for t, *rest in rows(3)]
    for form in ("%d/%m/%Y %H:%M:%S", "%m/%d/%Y %H:%M:%S"):
        lines = [f"1,{text(t, form)},{lat},{lon},12,0" for t, lat, lon, *_ in rows(3) + later]
        recording = read(tmp_path, "mmsi,time,lat,lon,sog,cog\n" + "\n".join(lines))
        assert recording.reports.time[0] == START


# ------------------------------------------------------------------ headings, delimiters, packing


@pytest.mark.parametrize(
    "heading",
    [
        "MMSI,BaseDateTime,LAT,LON,SOG,COG",
        "mmsi,base_date_time,latitude,longitude,sog,cog",
        "mmsi, Time ,Latitude_degrees,Longitude_degrees,SOG_knots,COG_degrees",
        '"MMSI","timestamp","Latitude","Longitude","Speed over ground","Course over ground"',
        "MMSI,date_time_utc,latitude,longitude,speed_over_ground,course_over_ground",
        "mmsi,aikaleima,leveysaste,pituusaste,nopeus,suunta",
        "MMSI,Tidspunkt,Breddegrad,Lengdegrad,Fart,Kurs",
    ],
)
def test_headings_of_providers(tmp_path, heading):
    require_one_vessel(read(tmp_path, table(heading=heading)))


@pytest.mark.parametrize(
    ("delimiter", "decimal"), [(";", "."), (";", ","), ("\t", "."), (",", ",")]
)
def test_delimiters_and_decimals(tmp_path, delimiter, decimal):
    heading = "mmsi,time,lat,lon,sog,cog".replace(",", delimiter)
    require_one_vessel(read(tmp_path, table(lambda t: f"{t:.0f}", heading, delimiter, decimal)))


def zipped(data):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        archive.writestr("recording.csv", data)
    return out.getvalue()


@pytest.mark.parametrize(
    "pack",
    [
        gzip.compress,
        lzma.compress,
        zipped,
        lambda data: b"\xef\xbb\xbf" + data,
        lambda data: data.decode().encode("utf-16"),
        lambda data: data.replace(b"\n", b"\r\n"),
    ],
)
def test_packed_and_encoded(tmp_path, pack):
    require_one_vessel(read(tmp_path, pack(table().encode())))


def test_ais_catcher(tmp_path):
    records = [
        {
            "class": "AIS", "rxtime": text(t, "%Y%m%d%H%M%S"), "rxuxtime": t, "mmsi": 219000001,
            "type": 1, "timestamp": 17, "lat": lat, "lon": lon, "speed": sog, "course": cog,
        }
        for t, lat, lon, sog, cog in rows()
    ]  # fmt: skip
    require_one_vessel(read(tmp_path, "\n".join(map(json.dumps, records)), "a.jsonl"))
    records[3] |= {"type": 5, "lat": None, "lon": None}
    records[4] |= {"type": 4}
    records[5] |= {"type": 21}
    recording = read(tmp_path, gzip.compress("\n".join(map(json.dumps, records)).encode()))
    assert recording.counts == {"no report": 1, "base station": 1, "aid to navigation": 1}
    listed = read(tmp_path, json.dumps(records), "a.json")
    assert listed.counts == recording.counts


def test_aisstream(tmp_path):
    records = []
    for k, (t, lat, lon, sog, cog) in enumerate(rows()):
        kind = "ShipStaticData" if k == 7 else "PositionReport"
        body = {"UserID": 219000001, "Timestamp": 17}
        position = {"Latitude": lat, "Longitude": lon, "Sog": sog, "Cog": cog}
        time = text(t, "%Y-%m-%d %H:%M:%S.318353 +0000 UTC")
        meta = {"MMSI": 219000001, "latitude": lat, "longitude": lon, "time_utc": time}
        message = {kind: body | ({} if k == 7 else position)}
        records.append({"MessageType": kind, "MetaData": meta, "Message": message})
    recording = read(tmp_path, "\n".join(map(json.dumps, records)), "a.jsonl")
    assert recording.counts == {"no report": 1}
    assert len(recording.reports) == N - 1
    assert recording.reports.vessels == ("219000001",)


# ------------------------------------------------------------------ NMEA


def sentence(moment_form, **changes):
    from pyais.encode import encode_dict

    lines = []
    for t, lat, lon, sog, cog in rows(20):
        fields = {"type": 1, "mmsi": 219000001, "lat": lat, "lon": lon, "speed": sog, "course": cog}
        lines.append(moment_form(t, encode_dict(fields | changes, talker_id="AI")[0]))
    return "\n".join(lines)


@pytest.mark.parametrize(
    "form",
    [
        lambda t, s: f"{t:.0f},{s}",
        lambda t, s: f"{t * 1000:.0f} {s}",
        lambda t, s: f"\\s:r1,c:{t:.0f}*00\\{s}",
        lambda t, s: f"\\g:1-1-3*00\\\\c:{t:.0f}*00\\{s}",
        lambda t, s: f"{s},{t:.0f}",
        lambda t, s: f"{s} {t * 1000:.0f}",
    ],
)
def test_nmea_with_times_in_every_place(tmp_path, form):
    require_one_vessel(read(tmp_path, sentence(form), "a.nmea"), n=20)


def test_nmea_without_times(tmp_path):
    with pytest.raises(ValueError, match=r"20 unreadable. Row 0 .*time is missing"):
        read(tmp_path, sentence(lambda t, s: s), "a.nmea")


def test_long_range_messages(tmp_path):
    data = sentence(lambda t, s: f"{t:.0f},{s}", type=27)
    recording = read(tmp_path, data, "a.nmea")
    assert len(recording.reports) + len(recording.rejected) == 20
    assert set(recording.counts) <= {"repeated position"}  # a tenth of a minute is 185 m


# ------------------------------------------------------------------ what is not available


def row(k, **changes):
    t, lat, lon, sog, cog = rows(20)[k]
    return {"time": t, "vessel": "1", "lat": lat, "lon": lon, "sog": sog, "cog": cog} | changes


@pytest.mark.parametrize("cog", [-0.1, -196.5, 360.0, 409.5, 511.0, None, ""])
def test_a_course_that_is_not_available(cog):
    recording = screen_rows([row(k, **({"cog": cog} if k == 3 else {})) for k in range(10)])
    assert recording.rejected == ()
    assert (recording.without_course, recording.without_speed) == (1, 0)
    assert recording.reports.kinds[3] == "truncated AIS"


@pytest.mark.parametrize("sog", [102.3, 1023.0, -1.0, None, ""])
def test_a_speed_that_is_not_available(sog):
    recording = screen_rows([row(k, **({"sog": sog} if k == 3 else {})) for k in range(10)])
    assert recording.rejected == ()
    assert (recording.without_course, recording.without_speed) == (0, 1)


@pytest.mark.parametrize(
    "position", [{"lat": 91.0, "lon": 181.0}, {"lat": -111.0}, {"lon": 181.0}, {"lat": None}]
)
def test_a_position_that_is_not_available(position):
    recording = screen_rows([row(k, **(position if k == 3 else {})) for k in range(10)])
    assert recording.counts == {"no position": 1}


@pytest.mark.parametrize(
    ("mmsi", "reason"), [("002190000", "base station"), ("992190001", "aid to navigation")]
)
def test_senders_that_are_no_vessels(mmsi, reason):
    recording = screen_rows([*(row(k) for k in range(10)), row(3, vessel=mmsi)])
    assert recording.counts == {reason: 1}


def test_an_error_shows_a_row_and_counts_by_reason():
    bad = [row(0, lat=91.0), row(1, time="yesterday"), row(2, lat=91.0), row(3, vessel="")]
    with pytest.raises(ValueError, match="no usable report among 4 rows") as error:
        screen_rows(bad)
    message = str(error.value)
    assert "2 no position, 1 unreadable, 1 no identity" in message
    assert "Row 0 (time=1720562400.0, vessel='1', lat=91.0, lon=11.0): latitude 91" in message
    assert len(message) < 300


# ------------------------------------------------------------------ the time stamps' resolution


def test_two_reports_in_one_second_a_metre_apart():
    extra = row(4) | {"lat": row(4)["lat"] + 1e-5}
    recording = screen_rows([*(row(k) for k in range(10)), extra])
    assert recording.rejected == ()
    assert recording.reports.vessels == ("1",)


@pytest.mark.parametrize("knots", [31.0, 33.0, 45.0])
def test_stamps_that_are_cut_to_whole_seconds(knots):
    rng = np.random.default_rng(1)
    times = 2.0 * np.arange(300) + rng.uniform(-0.15, 0.15, 300) + 1000
    lat = 55.0 + knots * 1852 / 3600 * (times - 1000) / 111_195
    recording = screen_rows([
        {"time": float(np.floor(t)), "vessel": "1", "lat": x, "lon": 11.0, "sog": knots, "cog": 0.0}
        for t, x in zip(times, lat, strict=True)
    ])  # fmt: skip
    assert recording.rejected == ()
    assert recording.reports.vessels == ("1",)


def test_a_ship_that_two_stations_hear():
    rng = np.random.default_rng(2)
    both = [row(k) for k in range(20)]
    both += [row(k) | {"lat": row(k)["lat"] + 1e-5 * rng.normal()} for k in range(20)]
    recording = screen_rows(sorted(both, key=lambda r: r["time"]))
    assert recording.rejected == ()
    assert recording.reports.vessels == ("1",)


@pytest.mark.parametrize(("step", "expected"), [(1.0, 1.0), (0.1, 0.1), (0.001, 0.001), (1e-5, 0)])
def test_the_resolution_of_stamps(step, expected):
    rows_of_steps = [row(k) | {"time": START + 10 * k + 3 * step} for k in range(5)]
    assert screen_rows(rows_of_steps).time_resolution == expected
