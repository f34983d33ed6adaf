"""Links: short, opened as a view, on phones, before all is loaded."""

import base64
import json
import re
import zlib
from collections.abc import Callable

import pytest
from playwright.sync_api import Browser, Page, Route, expect
from visit import SHOWN, becomes, link, plan, seconds, tab, wait

DOOR = {"width": 1440, "height": 900}


def sent(page: Page) -> str:
    """What *Copy link* puts into the clipboard."""
    page.evaluate("navigator.clipboard.writeText('')")
    page.get_by_role("button", name="Copy link").click()
    wait(page, lambda: "#" in page.evaluate("navigator.clipboard.readText()"))
    copied: str = page.evaluate("navigator.clipboard.readText()")
    return copied


def packed(text: str) -> str:
    deflate = zlib.compressobj(9, wbits=-15)
    return base64.urlsafe_b64encode(deflate.compress(text.encode()) + deflate.flush()).decode().rstrip("=")


def is_seen(page: Page) -> Callable[[str], bool]:
    """Whether all elements of a selector are whole in the window."""
    inside = "all => all.map(one => one.getBoundingClientRect()).every(({ left, top, right, bottom }) => left >= 0 && top >= 0 && right <= innerWidth && bottom <= innerHeight)"
    return lambda selector: page.locator(selector).count() > 0 and bool(page.locator(selector).evaluate_all(inside))


def test_a_link_is_short_and_opens_a_view_that_leads_into_the_lab(browser: Browser, url: str) -> None:
    context = browser.new_context(viewport=DOOR, permissions=["clipboard-read", "clipboard-write"])
    page = context.new_page()
    page.goto(url)
    page.wait_for_selector("canvas")
    made, copied = plan(page)["made"], sent(page)
    # The same scene as earlier versions wrote it: they open it, too (`link` of visit.py).
    assert len(copied) < 700 < 2000 < len(link(url, plan(page)))
    context.close()
    context = browser.new_context(first=True, viewport=DOOR)
    other = context.new_page()
    other.goto(copied)
    expect(other.get_by_role("heading", level=1)).to_have_text("The door")
    expect(other.get_by_text("How long do 70 people need to leave?")).to_be_visible()
    # It plays by itself, and what is moved runs again.
    wait(other, lambda: seconds(other) > 0.3)
    expect(other.get_by_role("button", name=re.compile(r"^\d+ of 70 have left|^All 70 have left"))).to_be_visible()
    assert other.locator(".sliders label").all_inner_texts() == ["Width of the door: 0.9 m", "Desired speed: 1.34 m/s"]
    controls, words, stage = other.evaluate(SHOWN)
    assert controls <= 12 and words <= 50 and stage > 0.6, (controls, words, stage)
    other.get_by_role("slider", name="Width of the door").fill("1.5")
    expect(other.get_by_text("Width of the door: 1.5 m")).to_be_visible()
    # Nothing is kept of it; a reload begins with what was sent.
    assert other.evaluate("localStorage.length + sessionStorage.length") == 0
    other.reload()
    expect(other.get_by_text("Width of the door: 0.9 m")).to_be_visible()
    other.get_by_role("link", name="Open in the lab").click()
    expect(other.get_by_role("navigation")).to_be_visible()
    becomes(other, lambda: plan(other)["made"], made)
    context.close()


def test_links_that_are_none_do_no_harm(browser: Browser, url: str) -> None:
    context = browser.new_context(viewport=DOOR)
    page = context.new_page()
    # 300 MB; no end; nothing of base64; not a scene.
    bomb = packed(json.dumps({"name": "x" * 300_000_000}))
    for hostile in (bomb, packed('{"name": "The door"}')[:-9], "no link!", packed("[7]"), "{%7B"):
        page.goto("about:blank")
        page.goto(f"{url}?view#{hostile}")
        expect(page.get_by_role("alert").first).to_contain_text(re.compile("cannot be read|Not all of the link"))
        page.wait_for_selector("canvas")
    context.close()


@pytest.mark.parametrize(("width", "height"), [(390, 844), (844, 390), (360, 640), (640, 360)])
def test_a_phone_opens_links_as_a_view(browser: Browser, url: str, width: int, height: int) -> None:
    context = browser.new_context(viewport={"width": width, "height": height}, has_touch=True, is_mobile=True)
    phone = context.new_page()
    phone.goto(url)
    phone.wait_for_selector("canvas")
    wait(phone, lambda: seconds(phone) > 0.2)
    lab = plan(phone)
    assert is_seen(phone)(".transport button.main")
    phone.goto("about:blank")
    phone.goto(link(url, lab))
    phone.wait_for_selector("canvas")
    wait(phone, lambda: seconds(phone) > 0.2)
    assert phone.get_by_role("navigation").count() == 0
    assert all(map(is_seen(phone), ("h1", ".transport button.main", ".time", ".sliders label", ".answer", "canvas")))
    assert phone.evaluate("document.documentElement.scrollWidth") <= width
    assert phone.evaluate(SHOWN)[2] > 0.35
    phone.get_by_role("link", name="Open in the lab").click()
    expect(phone.get_by_role("navigation")).to_be_visible()
    becomes(phone, lambda: plan(phone)["made"], lab["made"])
    context.close()


def test_until_the_lab_is_there_a_view_shows_its_room_and_how_much_has_come(browser: Browser, url: str) -> None:
    context = browser.new_context(viewport=DOOR)
    page = context.new_page()
    shares = "window.shares = []; new MutationObserver(() => { const bar = document.querySelector('.poster progress'); if (bar) shares.push(bar.position); }).observe(document, { subtree: true, childList: true, attributes: true });"
    page.add_init_script(shares)
    held: list[Route] = []
    context.route("**/lemons_lab.wasm*", lambda route: held.append(route))
    page.goto(url)
    wait(page, lambda: bool(held))
    expect(page.get_by_text("One moment …")).to_be_visible()
    # The outline, the crowd, and the gap of the door.
    assert page.locator(".poster svg path").count() == 3
    held[0].continue_()
    page.wait_for_selector("canvas")
    known = [share for share in page.evaluate("shares") if share >= 0]
    assert len(known) > 3 and known == sorted(known) and 0.9 < known[-1] <= 1, known
    # It comes once, for the page and its worker.
    tab(page, "Room")
    page.wait_for_timeout(500)
    assert len(held) == 1
    context.close()
