"""German and French: no text of the page stays English, and nothing breaks."""

import json
import re

import pytest
from playwright.sync_api import Browser, Page, expect
from visit import ROOT, becomes, plan, wait

SOURCES = ROOT / "lab/src"
#: Keeps whatever the page has shown, as the text of the element that it is in.
KEEP = """
    window.shown = new Set();
    const SAID = ["title", "aria-label", "aria-valuetext", "placeholder", "alt"];
    const keep = (node) => {
        const within = node.parentElement ?? node;
        // Sources of kinds are texts of data.
        if (!within.closest?.("#lab") || within.closest(".mix li")) return;
        if (node.nodeType === Node.TEXT_NODE && node.data.trim()) window.shown.add(node.parentElement?.textContent ?? "");
        for (const name of SAID) window.shown.add(node.getAttribute?.(name) ?? "");
        node.childNodes.forEach(keep);
    };
    const hear = (changes) => changes.forEach(({ target, addedNodes }) => [target, ...addedNodes].forEach(keep));
    new MutationObserver(hear).observe(document, { subtree: true, childList: true, characterData: true, attributeFilter: SAID });
"""

#: English words of the engine that are no German or French ones.
ENGLISH = set("the of is are be people must and or no by somebody walls nobody between which about number exit goal any with there from them".split())


def catalog(name: str) -> dict[str, str]:
    found: dict[str, str] = json.loads((SOURCES / f"words/{name}.json").read_text())
    return found


def words(text: str) -> set[str]:
    """Without places, names in quotes, file names, elements and commands."""
    return set(re.findall(r"[^\W\d_]{2,}", re.sub(r"<\w+>|\{\w+\}|\"[^\"]*\"|[\w/-]+\.\w+|lemons \w+", " ", text).lower()))


def visit(browser: Browser, url: str, locale: str, width: int = 1280) -> Page:
    context = browser.new_context(viewport={"width": width, "height": 844}, locale=locale, permissions=["clipboard-read", "clipboard-write"])
    page = context.new_page()
    page.add_init_script(KEEP)
    page.goto(url)
    page.wait_for_selector("canvas")
    return page


def english(page: Page, names: set[str]) -> dict[str, set[str]]:
    """What was shown with words that only English texts have, but names of the visitor's or of scenes."""
    language = page.evaluate("document.documentElement.lang")
    texts = catalog(language)
    own = (set().union(*map(words, texts)) | ENGLISH) - set().union(*map(words, [*texts.values(), *catalog(f"engine.{language}").values()]))
    shown: list[str] = page.evaluate("[...window.shown]")
    return {text: found for text in shown if text.strip() not in names and (found := words(text) & own)}


@pytest.mark.parametrize(("locale", "title", "people"), [("de-AT", "Die Tür", "70 Personen in"), ("fr-CA", "La porte", "70 personnes placées en")])
def test_every_tab_is_in_the_language_of_the_browser(browser: Browser, url: str, locale: str, title: str, people: str) -> None:
    page = visit(browser, url, locale)
    expect(page.get_by_text(people)).to_be_visible()
    assert page.evaluate("document.documentElement.lang") == locale[:2]
    expect(page.get_by_text(title, exact=True)).to_be_visible()
    # The numbers stay where they belong.
    if locale.startswith("fr"):
        words = "130 spectateurs contournent un pilier et sortent par un tunnel large de 2,5 m et long de 8 m."
        expect(page.get_by_text(words)).to_be_visible()
    tabs = page.locator("header nav button")
    for k in range(6):
        tabs.nth(k).click()
        while (closed := page.locator(".sheet details:not([open]) > summary")).count():
            closed.first.click()
        page.wait_for_timeout(300)
    tabs.nth(0).click()
    page.locator(".about summary").click()
    for card in page.locator("button.card").all():
        card.click()
        page.wait_for_timeout(300)
    page.locator("button.card").first.click()
    page.locator(".sheet .buttons button").first.click()
    page.locator(".sliders input[type=range]").nth(1).fill("1.2")
    # The people of the wider door are there.
    becomes(page, lambda: plan(page)["made"]["base"]["room"]["doors"][0]["width"], 1.2)

    def menu() -> bool:
        """Of the next person, as soon as the picture has people."""
        page.locator(".frame canvas").last.press("n")
        page.locator(".frame canvas").last.press("Shift+F10")
        return page.get_by_role("menu").count() == 1

    wait(page, menu)
    page.keyboard.press("Escape")
    # What is said of a person under the mouse, who is dragged onto others.
    tabs.nth(2).click()
    page.locator(".about summary").click()
    page.locator(".transport button").first.click()
    box = page.locator(".frame canvas").last.bounding_box()
    assert box
    for k in range(200):
        x, y = box["x"] + (0.1 + 0.02 * (k % 40)) * box["width"], box["y"] + (0.35 + 0.07 * (k // 40)) * box["height"]
        page.mouse.move(x, y)
        page.wait_for_timeout(50)
        if page.locator("canvas.over-person").count():
            break
    page.mouse.down()
    for k in range(30):
        page.mouse.move(x + 3 * k, y)
        page.wait_for_timeout(30)
    expect(page.locator("section.panel .note[role=status]").last).to_have_text(re.compile("berlapp|recouvre"))
    page.mouse.up()
    expect(page.get_by_text(re.compile("Änderung von Hand|changement à la main"))).to_be_visible()
    # Names of the visitor's own stay as they are, also where they are words of the page.
    page.locator(".name input").fill("Room")
    page.locator(".name input").press("Enter")
    tabs.nth(3).click()
    name = page.locator("fieldset input[type=text]").first
    name.fill("right")
    name.press("Enter")
    page.locator(".tools button").last.click()
    wait(page, lambda: bool(page.locator("footer p").first.text_content()))
    tabs.nth(5).click()
    with page.expect_download():
        page.locator(".take button").filter(has_text="PNG").click()
    page.locator(".transport button").nth(3).click()
    # A map, and a mechanical step that is too long.
    for kind in ("mean", "density"):
        page.locator(".legend").first.locator("select").nth(1).select_option(kind)
        expect(page.locator(".legend .note").first).to_have_text(re.compile(r"^\d (Bild|Bilder|image|images) (von|de) 0"))
    step = page.locator(".numbers .panel input").nth(1)
    step.fill("0.009")
    step.press("Tab")
    page.locator(".numbers .panel > .warning").first.wait_for()
    page.locator(".take button").filter(has_text=re.compile("^(Bericht|Rapport)")).click()
    page.locator("main.report").wait_for()
    assert page.locator("main.report h1").text_content() == "Room"
    assert page.locator("main.report").get_by_text('"right"').count() == 5
    tabs.nth(0).click()
    page.locator(".scenes button").nth(1).click()
    page.locator(".scenes button").nth(2).click()
    expect(page.locator(".scenes strong").first).to_have_text("Room")
    assert english(page, {"Room", "Room (Kopie)", "Room (copie)", "right", "English"}) == {}
    # Numbers have a comma, French colons a space before them; the window has the name of the scene, too.
    shown = [re.sub(r"FMI \d\.\d|LEMONS(-Labor)? \d\S*|https?:\S+|1991-1-1.*|[\w-]+\.\w{2,}", "", text) for text in page.evaluate("[...window.shown]")]
    assert [text for text in shown if re.search(r"\d\.\d", text)] == []
    assert locale[:2] != "fr" or [text for text in shown if re.search(r"[^\W\d_]:( |$)", text)] == []
    assert page.title() == ("Room\u00a0: Laboratoire LEMONS" if locale.startswith("fr") else "Room: LEMONS-Labor")
    page.context.close()


@pytest.mark.parametrize(("locale", "words"), [("de-AT", "3000 Personen passen nicht ohne Überlappung auf"), ("fr-CA", "3000 personnes ne tiennent pas sur")])
def test_what_the_engine_refuses_is_in_the_language(browser: Browser, url: str, locale: str, words: str) -> None:
    page = visit(browser, url, locale)
    page.locator("header nav button").nth(2).click()
    field = page.get_by_role("spinbutton", name=re.compile("^Person(en|nes)$"))
    field.fill("3000")
    field.press("Tab")
    expect(page.get_by_role("alert").filter(has_text=words)).to_be_visible()
    page.context.close()




def test_words_of_the_engine_are_not_english() -> None:
    for language in ("de", "fr"):
        said = catalog(f"engine.{language}").items()
        assert {sentence for sentence, text in said if words(re.sub(r"\w+_\w+|--\S+|docs/\S+", "", text)) & ENGLISH} == set()


def test_the_language_can_be_chosen_and_is_kept(browser: Browser, url: str) -> None:
    page = visit(browser, url, "en-GB", 390)
    page.get_by_role("combobox", name="Language").select_option(label="Français")
    expect(page.get_by_role("button", name="Mouvement")).to_be_visible()
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    page.reload()
    expect(page.get_by_role("button", name="Mouvement")).to_be_visible()
    page.get_by_role("combobox", name="Langue").select_option(label="English")
    expect(page.get_by_role("button", name="Motion")).to_be_visible()
    page.context.close()


def test_the_catalogs_have_the_texts_of_the_page_and_their_places() -> None:
    german, french = catalog("de"), catalog("fr")
    assert len(german) > 800
    # In one order, too: of two changes of the same text there is one conflict.
    assert list(german) == list(french) == sorted(german, key=lambda text: (text.lower(), text))
    places = lambda text: set(re.findall(r"\{\w+\}", text))
    assert [text for text in german if not places(text) == places(german[text]) == places(french[text])] == []
    # `tsc` refuses texts of the page that are not there, not those that nobody says any more.
    code = "".join(path.read_text() for path in SOURCES.glob("*.ts*"))
    assert [text for text in german if json.dumps(text, ensure_ascii=False) not in code and f"'{text}'" not in code] == []


@pytest.mark.parametrize("locale", ["en-GB", "de-DE", "fr-FR"])
def test_what_is_above_the_stage_are_two_rows(browser: Browser, url: str, locale: str) -> None:
    page = visit(browser, url, locale, 1280)
    for rows in (page.locator("header > *"), page.locator(".stage > .bar > *")):
        middles = [box["y"] + box["height"] / 2 for part in rows.all() if (box := part.bounding_box())]
        assert len(middles) > 3 and max(middles) - min(middles) < 8, middles
    page.context.close()
