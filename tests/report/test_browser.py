"""The page in a browser: headless Chromium opens it, reads it, and switches tracks off."""

import json
import shutil
import time

import pytest

from trackmetrics import report

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def browser():
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for argument in ("headless=new", "no-sandbox", "disable-gpu", "disable-dev-shm-usage"):
        options.add_argument(f"--{argument}")
    options.add_argument("--window-size=1360,1000")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    service = webdriver.ChromeService(shutil.which("chromedriver"))
    driver = webdriver.Chrome(options, service)
    driver.execute_cdp_cmd("Network.enable", {})
    offline = {"offline": True, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0}
    driver.execute_cdp_cmd("Network.emulateNetworkConditions", offline)
    yield driver
    driver.quit()


def until(browser, condition):
    """Waits until a JavaScript expression holds."""
    end = time.monotonic() + 60
    while time.monotonic() < end:
        if browser.execute_script(f"return Boolean({condition})"):
            return
        time.sleep(0.05)
    trouble = browser.execute_script("return document.querySelector('#message').textContent")
    pytest.fail(f"never came true: {condition}; {trouble}")


def opened(browser, path, log, diagnosis):
    """Opens the page of a diagnosis."""
    report.write_page(path, diagnosis, log)
    visit(browser, path)


def visit(browser, path):
    """Opens a page and waits for its figures."""
    browser.get(path.as_uri())
    until(browser, "document.documentElement.dataset.ready")


def tracks_drawn(browser):
    """The tracks whose lines the comparison shows."""
    return browser.execute_script(
        "return [...new Set(document.querySelector('#comparison').data.map((t) => t.name))]"
    )


def switch(browser, name):
    """Clicks a track's switch and waits for the comparison."""
    box = browser.find_element("css selector", f"input[aria-label='Draw {name}']")
    wanted = json.dumps(name), json.dumps(not box.is_selected())
    browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", box)
    box.click()
    until(
        browser,
        "JSON.parse(document.querySelector('#comparison').dataset.tracks)"
        f".includes({wanted[0]}) === {wanted[1]}",
    )
    until(browser, "document.querySelector('#comparison .main-svg')")


def quiet(browser):
    """Whether the console has said nothing."""
    assert browser.get_log("browser") == []


def check_page(browser, diagnosis):
    """Verdicts, figures, and a track that goes and comes back."""
    worst = diagnosis.by_severity()
    shown = browser.find_elements("css selector", "#overview tbody .chip")
    assert [s.text.split(" ", 1)[1] for s in shown] == [t.verdict.replace("_", " ") for t in worst]
    assert sorted(tracks_drawn(browser)) == sorted(t.track for t in worst[:8])
    first = worst[0].track
    until(browser, "document.querySelector('#track-0 .track-figure .main-svg')")
    switch(browser, first)
    time.sleep(0.2)
    assert first not in tracks_drawn(browser)
    assert not browser.find_element("css selector", "#track-0").is_displayed()
    switch(browser, first)
    time.sleep(0.2)
    assert first in tracks_drawn(browser)
    assert browser.find_element("css selector", "#track-0").is_displayed()
    quiet(browser)


@pytest.mark.data
def test_the_published_run(browser, tmp_path, published):
    log, diagnosis = published
    opened(browser, tmp_path / "out.html", log, diagnosis)
    check_page(browser, diagnosis)
    verdicts = {
        row.get_attribute("data-name"): row.text
        for row in browser.find_elements("css selector", "#overview tbody tr")
    }
    assert "startup then pessimistic" in verdicts["MV Iron Falcon2"]
    assert "NIS settled 36 min" in verdicts["MV Iron Falcon2"]
    assert "NEES settled 65 min" in verdicts["MV Iron Falcon2"]
    assert "NIS pessimistic" in verdicts["SS Iron Aurora1"]
    assert "0.207" in verdicts["SS Iron Aurora1"]
    assert "late divergence" in verdicts["SS Northern Star0"]
    assert "NEES from 113 min" in verdicts["SS Northern Star0"]


def test_a_synthetic_log(browser, tmp_path, small):
    opened(browser, tmp_path / "out.html", *small)
    check_page(browser, small[1])


def test_a_hundred_tracks(browser, tmp_path, fleet_page):
    path = tmp_path / "out.html"
    path.write_text(fleet_page, encoding="utf-8")
    visit(browser, path)
    find = browser.find_element("css selector", "#find")
    find.send_keys("vessel 04")
    visible = "[...document.querySelectorAll('#overview tbody tr')].filter((r) => !r.hidden).length"
    until(browser, f"{visible} === 10")
    find.clear()
    find.send_keys(" ")
    until(browser, f"{visible} === 100")
    link = browser.find_element("link text", "vessel 099")
    browser.execute_script("arguments[0].click()", link)
    until(browser, "document.querySelectorAll('details[data-drawn]').length === 2")
    quiet(browser)


def test_a_list_of_many_tracks_is_unpacked(browser, tmp_path, small, monkeypatch):
    from trackmetrics.report import diagnosis_page

    monkeypatch.setattr(diagnosis_page, "MAX_PLAIN_ROWS", 3)
    monkeypatch.setattr(diagnosis_page, "BLOCK", 3)
    opened(browser, tmp_path / "out.html", *small)
    check_page(browser, small[1])
    page = (tmp_path / "out.html").read_text(encoding="utf-8")
    assert "<tr data-index" not in page


def test_tables_themes_and_sorting(browser, tmp_path, small):
    opened(browser, tmp_path / "out.html", *small)
    updates = browser.find_element("css selector", "#track-0 .updates summary")
    browser.execute_script("arguments[0].click()", updates)
    until(browser, "document.querySelectorAll('#track-0 .updates tbody tr').length === 60")
    colour = "document.querySelector('#comparison .main-svg').style.background"
    light = browser.execute_script(f"return {colour}")
    button = browser.find_element("css selector", "#theme")
    button.click()
    button.click()
    assert "dark" in button.text
    until(browser, f"{colour} !== {json.dumps(light)}")
    browser.find_element("css selector", "[data-sort=name]").click()
    names = [
        row.get_attribute("data-name")
        for row in browser.find_elements("css selector", "#overview tbody tr")
    ]
    assert names == sorted(small[0].tracks)
    quiet(browser)
