"""The viewer's page in a real browser: what people do with it, by pointer and by keyboard."""

import math
import subprocess
import unittest

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select

from browser import Browser
from viewer import Viewer, tool


class PageTest(unittest.TestCase):
    def setUp(self):
        self.viewer = self.enterContext(Viewer())
        self.folder = self.viewer.folder
        self.page = self.enterContext(Browser())
        self.page.open(self.viewer.address)

    def tearDown(self):
        self.assertEqual(self.page.messages(), [])

    # --- helpers ---

    def element(self, name):
        return self.page.driver.find_element(By.ID, name)

    def value(self, section, key):
        return self.page.run(
            "return fetch('scene').then((a) => a.json()).then((s) => "
            "s.sections.find((x) => x.id === arguments[0]).keys.find((k) => k.key === arguments[1]).value)",
            section,
            key,
        )

    def finish(self):
        self.page.until("document.body.dataset.finished === 'true'", "a finished picture")
        self.page.until("canvas.dataset.number > 0", "a picture")

    def after_change(self, act):
        """Acts, waits until the picture shows the change and is done."""
        before = self.page.run("return Number(document.body.dataset.change)")
        act()
        self.page.until(f"Number(document.body.dataset.change) > {before}", "a changed picture")
        self.finish()

    def drag(self, dx, dy):
        chain = ActionChains(self.page.driver).move_to_element(self.element("picture"))
        chain.click_and_hold().move_by_offset(dx, dy).release().perform()

    def open_section(self, name):
        self.page.run(
            "document.querySelector(`details[data-id=\"${arguments[0]}\"]`).open = true", name
        )

    # --- tests ---

    def test_drag_orbits_and_undo_goes_back(self):
        before = self.value("camera", "position")
        self.after_change(lambda: self.drag(120, 40))
        moved = self.value("camera", "position")
        self.assertNotEqual(moved, before)
        self.assertAlmostEqual(sum(v * v for v in moved), 16, places=6)  # around the target
        self.after_change(lambda: self.element("undo").click())
        self.assertEqual(self.value("camera", "position"), before)
        self.after_change(lambda: self.element("redo").click())
        self.assertEqual(self.value("camera", "position"), moved)

    def test_no_motion_of_a_drag_is_lost(self):
        height = self.page.run("return parseInt(canvas.style.height)")
        chain = ActionChains(self.page.driver, duration=20).move_to_element(self.element("picture"))
        chain.click_and_hold()
        for _ in range(40):
            chain.move_by_offset(3, 0)
        self.after_change(chain.release().perform)
        self.page.until("document.body.dataset.finished === 'true'", "a finished picture")
        x, _, z = self.value("camera", "position")
        self.assertAlmostEqual(math.atan2(-x, z), 3 * 120 / height, places=3)

    def test_gestures_are_undone_one_by_one(self):
        self.after_change(lambda: self.drag(60, 0))
        moved = self.value("camera", "position")
        slider = self.page.driver.find_element(By.CSS_SELECTOR, "[aria-label='g, slider']")
        self.after_change(lambda: slider.send_keys(*[Keys.ARROW_RIGHT] * 12))
        self.assertNotEqual(self.value("volume[1].medium", "g"), 0.3)
        self.after_change(lambda: self.element("undo").click())
        self.assertEqual(self.value("volume[1].medium", "g"), 0.3)
        self.assertEqual(self.value("camera", "position"), moved)

    def test_pages_follow_each_other(self):
        with Browser() as other:
            other.open(self.viewer.address)
            self.after_change(lambda: self.drag(60, 0))
            moved = self.value("camera", "position")
            other.until(
                "document.getElementById('key_camera.position').value === "
                f"'{', '.join(f'{v:.6g}' for v in moved)}'", "the other page's camera")

    def test_keys_work_after_a_click_on_the_bar(self):
        self.after_change(lambda: self.drag(60, 0))
        self.page.driver.find_element(By.CSS_SELECTOR, "input[value='sun']").click()
        self.after_change(lambda: ActionChains(self.page.driver).key_down(Keys.CONTROL).send_keys("z")
                          .key_up(Keys.CONTROL).perform())
        self.assertEqual(self.value("camera", "position"), [0, 0, 4])

    def test_keys_orbit_pan_and_move(self):
        self.element("picture").click()
        keys = lambda *k: self.after_change(lambda: self.element("picture").send_keys(*k))
        keys(Keys.ARROW_LEFT)
        self.assertLess(self.value("camera", "position")[0], 0)
        target = self.value("camera", "target")
        self.assertEqual(target, [0, 0, 0])
        keys(Keys.SHIFT, Keys.ARROW_UP)
        self.assertGreater(self.value("camera", "target")[1], 0)
        keys("+")
        position, target = self.value("camera", "position"), self.value("camera", "target")
        self.assertAlmostEqual(sum((a - b) ** 2 for a, b in zip(position, target)) ** 0.5, 3.6, places=6)

    def test_sun_is_dragged(self):
        self.page.driver.find_element(By.CSS_SELECTOR, "input[value='sun']").click()
        self.after_change(lambda: self.drag(0, -60))
        self.assertGreater(self.value("sun[1]", "direction")[1], 0.58)  # it stood at .577

    def test_sun_of_a_clear_sky_is_dragged(self):
        self.open_section("environment")
        Select(self.element("key_environment.type")).select_by_visible_text("clear")
        self.page.run(
            "return fetch('scene').then((a) => a.json()).then((s) => fetch('scene', {method: 'POST', "
            "headers: {'Content-Type': 'application/json'}, body: JSON.stringify({edits: [{remove: 'sun[1]'}]})}))"
        )
        self.page.until("!document.querySelector('details[data-id=\"sun[1]\"]')", "a scene without the sun")
        north = self.value("environment", "north")
        self.page.driver.find_element(By.CSS_SELECTOR, "input[value='sun']").click()
        self.after_change(lambda: self.drag(0, -60))
        self.assertGreater(self.value("environment", "elevation"), 37 + 5)
        self.assertAlmostEqual(self.value("environment", "azimuth"), 245 - 360)
        self.assertEqual(self.value("environment", "north"), north)

    def test_numbers_keep_their_digits(self):
        position = [5.812345678901, 0.5, 4.123456789]
        self.page.run(
            "return fetch('scene', {method: 'POST', headers: {'Content-Type': 'application/json'}, body: "
            "JSON.stringify({edits: [{section: 'camera', key: 'position', value: arguments[0]}, "
            "{section: 'render', key: 'seed', value: 123456789}]})})",
            position,
        )
        self.page.until("document.getElementById('key_camera.position').value.startsWith('5.81235')", "the place")
        self.open_section("camera")
        self.open_section("render")
        seed = self.element("key_render.seed")
        self.assertEqual(seed.get_attribute("value"), "123456789")

        def type_z():
            field = self.element("key_camera.position")
            text = field.get_attribute("value").rsplit(",", 1)[0] + ", 5"
            field.send_keys(Keys.CONTROL, "a", Keys.NULL, text, Keys.ENTER)

        self.after_change(type_z)
        self.assertEqual(self.value("camera", "position"), [*position[:2], 5])

    def test_click_focuses(self):
        self.page.driver.find_element(By.CSS_SELECTOR, "input[value='focus']").click()
        self.finish()
        self.after_change(lambda: self.element("picture").click())
        self.assertAlmostEqual(self.value("camera", "focus_distance"), 3.05, delta=0.15)  # the ball's front
        self.assertIn("f stop", self.page.text("help"))

    def test_values_are_typed_and_refused(self):
        self.finish()
        middle = self.page.colours()[16 * 4 + 8]
        albedo = self.element("key_volume[1].medium.albedo")
        every = (Keys.CONTROL, "a", Keys.NULL)  # what is written is replaced
        self.after_change(lambda: albedo.send_keys(*every, "0.2", Keys.ENTER))
        self.assertEqual(self.value("volume[1].medium", "albedo"), [0.2, 0.2, 0.2])
        darker = self.page.colours()[16 * 4 + 8]
        self.assertLess(sum(darker), 0.7 * sum(middle))
        albedo.send_keys(*every, "2", Keys.ENTER)
        self.page.until("document.getElementById('error').textContent", "a refusal")
        self.assertEqual(self.page.text("error"), "albedo: found 2, expected a number in [0, 1]")
        self.assertEqual(self.value("volume[1].medium", "albedo"), [0.2, 0.2, 0.2])

    def test_layers_and_filter(self):
        self.finish()
        colour = self.page.colours()
        self.after_change(lambda: Select(self.element("layer")).select_by_visible_text("depth"))
        self.assertFalse(self.page.run("return document.getElementById('scale').hidden"))
        self.assertNotEqual(self.page.colours(), colour)
        self.after_change(lambda: Select(self.element("layer")).select_by_visible_text("colour"))
        self.after_change(lambda: self.element("filter").click())
        self.page.until("document.getElementById('progress').textContent.includes('after the filter')",
                        "a filtered picture")

    def test_tone_maps_are_those_there_are(self):
        self.finish()
        colours, choice = self.page.colours(), Select(self.element("tone_map"))
        names = [option.text for option in choice.options]
        self.assertEqual(names[:3], ["srgb", "neutral", "filmic"])
        for name in ("filmic", names[-1]):  # the last is a view of OCIO, where pvol has it
            choice.select_by_visible_text(name)
            colours = self.page.other_colours(colours)

    def test_lights_are_added_and_removed(self):
        self.after_change(lambda: (Select(self.element("kinds")).select_by_visible_text("sun"),
                                   self.element("add").click()))
        self.assertEqual(self.value("sun[2]", "angle"), 0)
        remove = self.page.driver.find_element(By.CSS_SELECTOR, "button[aria-label='Remove Sun 2']")
        self.after_change(remove.click)
        self.assertEqual(len(self.page.driver.find_elements(By.CSS_SELECTOR, "details[data-id^=sun]")), 1)

    def test_a_picture_becomes_the_sky(self):
        sky = self.folder / "sky.exr"
        subprocess.run(["oiiotool", "--pattern", "constant:color=0.9,0.1,0.1", "8x4", "3", "-d", "float",
                        "-o", sky], check=True)
        self.open_section("environment")
        kind = Select(self.element("key_environment.type"))
        kind.select_by_visible_text("image")
        self.page.driver.switch_to.alert.dismiss()
        self.assertEqual(self.value("environment", "type"), "constant")
        self.assertEqual(kind.first_selected_option.text, "constant")

        def choose():
            kind.select_by_visible_text("image")
            self.page.driver.switch_to.alert.send_keys(str(sky))
            self.page.driver.switch_to.alert.accept()

        self.after_change(choose)
        red, green, _ = self.page.colours()[0]
        self.assertGreater(red, 2 * green)

    def test_what_is_saved_renders_the_same(self):
        self.after_change(lambda: self.drag(-90, 25))
        self.element("picture").send_keys(Keys.CONTROL, "s")
        self.element("file").clear()
        self.element("file").send_keys("saved.toml")
        self.element("do_save").click()
        self.page.until("!document.getElementById('save_dialog').open", "a saved scene")
        shown = bytes(self.page.run(
            "return fetch('picture').then((a) => a.arrayBuffer()).then((b) => [...new Uint8Array(b)])"))
        picture = self.folder / "saved.png"
        subprocess.run([tool("pvol-render"), self.folder / "saved.toml", "-o", picture, "--quiet"], check=True)
        raw = self.folder / "saved.ppm"
        subprocess.run(["oiiotool", picture, "-o", raw], check=True)
        self.assertEqual(raw.read_bytes()[-160 * 90 * 3:], shown)

    def test_works_in_the_dark_and_on_fine_screens(self):
        with Browser(scale=2, dark=True) as page:
            page.open(self.viewer.address)
            self.assertEqual(page.run("return canvas.width / parseInt(canvas.style.width)"), 2)
            ground = page.run("return getComputedStyle(document.body).backgroundColor")
            self.assertEqual(ground, "rgb(32, 33, 36)")


if __name__ == "__main__":
    unittest.main()
