"""Materials and steps changed in the page, as the Trial and the command have them."""

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect
from visit import becomes, changed, download, example, fill, held, lemons, link, make, people, plan, play_until, same_table, tab, wait


def details(page: Page) -> None:
    page.get_by_text("Materials and steps").click()


def put(page: Page, label: str, value: float) -> None:
    """Fills a field, and waits until the scene has its number."""
    fill(page, label, value)
    field = page.get_by_role("spinbutton", name=label)
    wait(page, lambda: field.count() == 1 and float(field.input_value()) == value)


def attributes(trial: Path, file: str, element: str) -> list[dict[str, str]]:
    return [found.attrib for found in ElementTree.fromstring(held(trial)[file]).iter(element)]


def test_changed_materials_and_steps_run_as_the_command_runs_them(page: Page, url: str, tmp_path: Path) -> None:
    (tmp_path / "before").mkdir()
    before = download(page, "Trial (zip)", tmp_path / "before")
    old = held(before)
    details(page)
    put(page, '"human_naked", Young modulus', 2e6)
    put(page, '"human_naked", shear modulus', 9e5)
    put(page, '"human_naked", normal damping', 900)
    put(page, '"human_naked", friction', 0.1)
    put(page, "Mechanical step", 5e-5)
    put(page, "Communication step", 0.02)
    becomes(page, lambda: plan(page)["made"].get("mechanics", {}).get("time_step"), 0.02)
    play_until(page, 3)
    shown = download(page, "Trajectories (CSV)", tmp_path)
    trial = download(page, "Trial (zip)", tmp_path)
    material = next(one for one in attributes(trial, "Materials.xml", "Material") if one["Id"] == "human_naked")
    assert (float(material["YoungModulus"]), float(material["ShearModulus"])) == (2e6, 9e5)
    contact = next(one for one in attributes(trial, "Materials.xml", "Contact") if {one["Id1"], one["Id2"]} == {"human_naked"})
    assert [float(contact[key]) for key in ("GammaNormal", "KineticFriction")] == [900, 0.1]
    (times,) = attributes(trial, "Parameters.xml", "Times")
    assert [float(times[key]) for key in ("TimeStep", "TimeStepMechanical")] == [0.02, 5e-5]
    lemons("run", trial, "--until", "3", "-o", tmp_path / "run.csv")
    same_table(shown, tmp_path / "run.csv")
    lemons("run", before, "--until", "3", "-o", tmp_path / "before.csv")
    assert (tmp_path / "before.csv").read_text() != (tmp_path / "run.csv").read_text()
    # A link has them; Undo takes one step back, and the button all of them.
    mechanics = plan(page)["made"]["mechanics"]
    other = page.context.new_page()
    other.goto(link(url, {"name": "Soft", **{key: plan(page)[key] for key in ("made", "crowd")}}))
    other.wait_for_selector("canvas")
    details(other)
    expect(other.get_by_role("spinbutton", name='"human_naked", Young modulus')).to_have_value("2000000")
    assert plan(other)["made"]["mechanics"] == mechanics
    other.close()
    page.get_by_role("button", name="Undo").click()
    expect(page.get_by_role("spinbutton", name="Communication step")).to_have_value("0.05")
    page.get_by_role("button", name="As the scene has them").click()
    expect(page.get_by_role("spinbutton", name='"human_naked", Young modulus')).to_have_value("4000000")
    assert held(download(page, "Trial (zip)", tmp_path)) == old


def test_frictions_are_those_of_the_trial_until_that_of_a_pair_is_changed(page: Page, tmp_path: Path) -> None:
    make(page, 8, 400, 400)
    contacts = lambda: [one for one in attributes(download(page, "Trial (zip)", tmp_path), "Materials.xml", "Contact") if "human_naked" in (one["Id1"], one["Id2"]) and {one["Id1"], one["Id2"]} <= {"human_naked", "concrete"}]
    details(page)
    pair = lambda one: " – ".join(dict.fromkeys((one["Id1"], one["Id2"])))
    field = lambda one: page.get_by_role("spinbutton", name=f'"{pair(one)}", friction', exact=True)
    before = contacts()
    # People have another friction with walls than with each other.
    assert sorted(float(one["KineticFriction"]) for one in before) == [0.4, 0.5]
    for one in before:
        assert float(field(one).input_value()) == float(one["KineticFriction"])
    # One pair alone.
    fill(page, '"human_naked", friction', 0.3)
    wait(page, lambda: "mechanics" in plan(page)["made"])
    assert plan(page)["made"]["base"]["friction"] is None
    after = contacts()
    assert {pair(one): float(one["KineticFriction"]) for one in after} == {"human_naked": 0.3, pair(next(one for one in before if "concrete" in one.values())): 0.5}
    for one in after:
        assert float(field(one).input_value()) == float(one["KineticFriction"])


def test_bounds_are_said_and_the_engine_s_advice_is_taken(page: Page, tmp_path: Path) -> None:
    details(page)
    for label, value, words in (
        ("Mechanical step", 0.06, "Mechanical step: 1e-9 to 0.05 s"),
        ("Communication step", 1e-6, "Communication step: 0.000002 to 10 s"),
        ('"human_naked", Young modulus', 6e6, '"human_naked", Young modulus: 1 to 5517240 N/m'),
        ('"human_naked", shear modulus', 1, '"human_naked", shear modulus: 1000000 to 1000000000000 N/m'),
        ('"human_naked", normal damping', -1, '"human_naked", normal damping: 0 to 1000000000 kg/s'),
    ):
        fill(page, label, value)
        expect(page.get_by_role("alert").filter(has_text=words)).to_be_visible()
    assert "mechanics" not in plan(page)["made"]
    fill(page, "Mechanical step", 0.005)
    numbers = page.get_by_role("region", name="Numbers")
    # The form, the warning and the command say the same, with the same limit.
    expect(numbers.get_by_text("The mechanical step is not stable. Stable up to 0.00084 s, without a warning up to")).to_be_visible()
    expect(numbers.get_by_text("is not stable (up to 8.4e-4 s): collisions in the contact of")).to_be_visible()
    expect(numbers.get_by_text("0.005 s, not stable (up to 0.00084 s)")).to_have_count(1)
    said = lemons("check", download(page, "Trial (zip)", tmp_path))
    assert "is not stable (up to 8.4e-4 s): collisions in the contact of" in said and "not stable (up to 8.4e-4 s);" in said
    # Below the limit, but with a warning.
    put(page, "Mechanical step", 7e-4)
    expect(numbers.get_by_text("The mechanical step is stable, but long. Stable up to 0.00084 s")).to_be_visible()
    expect(numbers.get_by_text("is stable (up to 8.4e-4 s), but long for the contact of")).to_be_visible()
    put(page, "Mechanical step", 0.005)
    limit = re.search(r"A step of at most ([\d.e-]+) s", said)
    assert limit
    button = page.get_by_role("button", name="Take the advised step")
    assert float(button.inner_text().split()[-2]) == float(limit[1])
    button.click()
    wait(page, lambda: plan(page)["made"]["mechanics"]["time_step_mechanical"] == pytest.approx(float(limit[1])))
    expect(button).to_have_count(0)
    assert "not stable" not in lemons("check", download(page, "Trial (zip)", tmp_path))


def test_the_friction_of_a_crowd_is_that_of_all_pairs_and_it_keeps_its_materials(page: Page, tmp_path: Path) -> None:
    example(page, "The door", 70)
    page.get_by_role("button", name="Pause").click()
    details(page)
    put(page, '"human_naked", friction', 0.2)
    expect(page.get_by_text('The slider and the tab Crowd set the friction of all pairs with people.')).to_be_visible()
    expect(page.get_by_role("slider", name="Friction")).to_have_value("0.4")
    expect(page.get_by_role("spinbutton", name='"concrete – human_naked", friction')).to_have_value("0.5")
    fill(page, '"human_naked", shear modulus', 1.2e6)
    wait(page, lambda: "mechanics" in plan(page)["made"])
    page.get_by_role("slider", name="Friction").fill("0.3")
    becomes(page, lambda: plan(page)["made"]["base"]["friction"], 0.3)
    for name in ("human_naked", "concrete – human_naked"):
        expect(page.get_by_role("spinbutton", name=f'"{name}", friction', exact=True)).to_have_value("0.3")
    trial = download(page, "Trial (zip)", tmp_path)
    assert 1.2e6 in {float(one["ShearModulus"]) for one in attributes(trial, "Materials.xml", "Material")}
    frictions = {float(one["KineticFriction"]) for one in attributes(trial, "Materials.xml", "Contact") if "human_naked" in one.values()}
    assert frictions == {0.3}
    # People of another material have its numbers.
    tab(page, "Crowd")
    page.get_by_label("Material").select_option(label="Clothes")
    expect(page.get_by_text("Not there any more: changed materials and steps.")).to_be_visible()
    assert "mechanics" not in plan(page)["made"]


def test_materials_with_very_long_ids_cannot_be_changed(page: Page, tmp_path: Path) -> None:
    long = "h" * 201
    trial = changed(download(page, "Trial (zip)", tmp_path), tmp_path / "long.zip", lambda text: text.replace("human_naked", long))
    tab(page, "Start")
    page.get_by_label("Open a zip").set_input_files(trial)
    expect(page.get_by_text('"long.zip": 5 people')).to_be_visible()
    details(page)
    expect(page.get_by_text("Materials whose Ids have more than 200 letters cannot be changed here.")).to_be_visible()
    expect(page.get_by_role("spinbutton", name=f'"{long}", Young modulus')).to_have_count(0)
    # What can be changed is still there after a reload.
    fill(page, '"concrete", shear modulus', 2e10)
    wait(page, lambda: "mechanics" in plan(page)["made"])
    page.reload()
    page.wait_for_selector("canvas")
    people(page, 5)
    assert plan(page)["made"]["mechanics"]["materials"][0]["shear_modulus"] == 2e10
