// The built page in a headless browser, served as any host would.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";
import { browser, field, here, open, pictures, serve, until } from "./help.mjs";

let host, chrome;
before(async () => {
  host = await serve();
  chrome = await browser();
});
after(async () => {
  await chrome?.close();
  host?.close();
});

const B = "#scenario=push_with_disturbance&case=with_ft&seed=1";
/** Of the address: the scenario with other numbers. */
const varied = (...lines) => `&with=${encodeURIComponent(JSON.stringify(lines))}`;
const say = (page) => page.locator("#say").textContent();
const problem = (page) => page.locator("#problem").textContent();
/** A file as a browser gives it when it is chosen. */
const choose = (page, ...files) =>
  page.setInputFiles(
    "#files",
    files.map(([name, text]) => ({ name, mimeType: "application/octet-stream", buffer: Buffer.from(text) })),
  );

/** Reads the pixels of the 3-D view: how many differ clearly from the background, and how many are of a kind. */
const pixels = (page) =>
  page.evaluate(() => {
    const canvas = document.querySelector("#stage canvas");
    const copy = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height });
    const context = copy.getContext("2d");
    context.drawImage(canvas, 0, 0);
    const { data } = context.getImageData(0, 0, copy.width, copy.height);
    const count = { all: data.length / 4, dark: 0, blue: 0 };
    for (let i = 0; i < data.length; i += 4) {
      const [r, g, b] = [data[i], data[i + 1], data[i + 2]];
      if (r + g + b < 330) count.dark++;
      if (b > 150 && r < 90 && g < 140) count.blue++;
    }
    return count;
  });

describe("the page", () => {
  test("loads without errors and draws the robot of every scenario", async () => {
    for (const name of [
      "push_with_disturbance",
      "push_and_slide",
      "push_away",
      "under_actuated",
      "quadruped_stand",
      "humanoid_stand",
    ]) {
      const { page, errors } = await open(chrome, `${host.address}#scenario=${name}`);
      await page.click("#play");
      await until(page, 0.2);
      await page.click("#play");
      await page.waitForTimeout(200);
      const seen = await pixels(page);
      assert.ok(seen.dark > 0.003 * seen.all, `${name}: ${JSON.stringify(seen)}`);
      if (name !== "quadruped_stand" && name !== "humanoid_stand") {
        // Thrust arrows.
        assert.ok(seen.blue > 200, `${name}: ${JSON.stringify(seen)}`);
      }
      await page.screenshot({ path: join(pictures, `${name}.png`) });
      assert.deepEqual(errors, [], name);
      await page.close();
    }
  });

  test("an empty view has no robot: the count of pixels means something", async () => {
    const { page } = await open(chrome, host.address + B);
    const with_robot = await pixels(page);
    await page.evaluate(() => (document.querySelector("#stage canvas").style.visibility = "visible"));
    // Looked at from below the ground, far away.
    await page.mouse.move(500, 250);
    for (let i = 0; i < 40; i++) await page.mouse.wheel(0, 800);
    await page.waitForTimeout(1500);
    const without = await pixels(page);
    assert.ok(without.dark < 0.2 * with_robot.dark, `${without.dark} ${with_robot.dark}`);
    await page.close();
  });

  test("runs experiment B, whose rows hold here: B4 among them", async () => {
    const { page, errors } = await open(chrome, host.address + B);
    await page.click("#measure");
    await page.waitForSelector("#results[open]", { timeout: 120_000 });
    const rows = await page.$$eval("#results-table tr[data-row=B4]", (list) => list.map((row) => row.textContent));
    assert.ok(rows.length >= 3, `${rows.length}`);
    for (const row of rows) assert.match(row, /^✓/);
    assert.equal(await page.locator("#results-table td.fail").count(), 0);
    await page.screenshot({ path: join(pictures, "measured.png") });
    assert.deepEqual(errors, []);
    await page.close();
  });

  test("keeps pace, pauses, steps and resets", async () => {
    const { page } = await open(chrome, host.address + B);
    await page.click("#step");
    await page.waitForFunction(() => window.wbqp.field("ticks")[0] > 0);
    await page.waitForTimeout(150);
    assert.equal((await field(page, "ticks"))[0], 1);
    await page.selectOption("#speed", "2");
    await page.click("#play");
    await until(page, 1);
    await page.click("#play");
    await page.waitForTimeout(1000);
    const [paused] = await field(page, "time");
    await page.waitForTimeout(300);
    assert.equal((await field(page, "time"))[0], paused);
    await page.click("#reset");
    await page.waitForFunction(() => window.wbqp.field("time")[0] === 0);
    await page.close();
  });

  test("a slider changes the command, and the link reproduces it", async () => {
    const { page } = await open(chrome, `${host.address}${B}&speed=Infinity`);
    const thrusts = async (page) => {
      await page.click("#play");
      // It stops at the scenario's end, at the same tick every time.
      await until(page, 24.999);
      return field(page, "efforts");
    };
    const plain = await thrusts(page);
    await page.click("#reset");
    await page.waitForFunction(() => window.wbqp.field("time")[0] === 0);
    // The set point of the normal force.
    await page.locator("#side .lil-title", { hasText: "contact_force" }).first().click();
    const slider = page.locator('#side input[aria-label="contact_force: set point normal / N"]').last();
    await slider.fill("2");
    await slider.press("Enter");
    await page.waitForFunction(() => location.hash.includes("changes"));
    const link = page.url();
    const changed = await thrusts(page);
    const most = Math.max(...plain.map((f, i) => Math.abs(f - changed[i])));
    assert.ok(most > 0.2, `${most}`);
    const force = -(await field(page, "contact/tip/true"))[0];
    assert.ok(Math.abs(force - 2) < 0.5, `${force}`);
    await page.close();
    const again = await open(chrome, link);
    const reproduced = await thrusts(again.page);
    // A change before the first tick is the same change.
    assert.deepEqual(reproduced, changed);
    assert.ok(Math.abs((await field(again.page, "time"))[0] - 25) < 1e-6);
    assert.ok(Math.abs(-(await field(again.page, "contact/tip/true"))[0] - 2) < 0.5);
    await again.page.close();
  });

  test("limits that contradict one another are explained", async () => {
    // One foot must push with more than the whole weight, and all must stay where they are.
    const stiff = varied(["set.contact.fl.force_min", 29]);
    const { page, errors } = await open(chrome, `${host.address}#scenario=quadruped_stand${stiff}&speed=10`);
    await page.click("#play");
    await page.waitForFunction(() => document.querySelector("#level").dataset.level !== "optimal", null, {
      timeout: 60_000,
    });
    await page.waitForFunction(() => /contradict/.test(document.querySelector("#say").textContent));
    await page.click("#play");
    assert.match(await say(page), /any one of these would have to give|given up/);
    assert.match(await say(page), /short by/);
    await page.screenshot({ path: join(pictures, "explained.png") });
    // A long text leaves the view free, also on a phone, until all of it is asked for.
    const share = () =>
      page.evaluate(() => {
        const [words, view] = ["words", "view"].map((id) => document.getElementById(id).getBoundingClientRect());
        return {
          wide: words.width / view.width,
          high: words.height / view.height,
          out: words.right > view.right || words.top < view.top,
        };
      });
    const small = await share();
    assert.ok(small.wide < 0.45 && small.high < 0.25 && !small.out, JSON.stringify(small));
    await page.click("#say .more");
    const large = await share();
    assert.ok(large.high > 2 * small.high && !large.out, `${JSON.stringify(small)} ${JSON.stringify(large)}`);
    await page.screenshot({ path: join(pictures, "explained-all.png") });
    await page.click("#say .more");
    assert.deepEqual(await share(), small);
    await page.setViewportSize({ width: 390, height: 844 });
    await page.waitForTimeout(300);
    const phone = await share();
    assert.ok(phone.high < 0.3 && !phone.out, JSON.stringify(phone));
    await page.screenshot({ path: join(pictures, "explained-phone.png") });
    await page.click("#say .more");
    assert.ok((await share()).high > phone.high && !(await share()).out);
    await page.screenshot({ path: join(pictures, "explained-phone-all.png") });
    assert.deepEqual(errors, []);
    await page.close();
  });

  test("the robot is pulled with the pointer", async () => {
    const { page } = await open(chrome, host.address + B);
    await page.click("#play");
    await until(page, 0.5);
    const before = await field(page, "position");
    const box = await page.locator("#stage canvas").boundingBox();
    const [x, y] = await page.evaluate(() => window.wbqp.whereIs("arm_link2"));
    await page.mouse.move(box.x + x, box.y + y);
    await page.mouse.down();
    await page.mouse.move(box.x + x + 20, box.y + y - 60, { steps: 8 });
    // Upwards, where the scenario does not send it.
    await page.waitForFunction((before) => window.wbqp.field("position")[2] - before[2] > 0.02, before);
    await page.screenshot({ path: join(pictures, "pulled.png") });
    await page.mouse.up();
    await page.close();
  });

  test("the wall is dragged, along its normal, and a robot that pushes follows it", async () => {
    // Nothing else pulls at it, so that it does not matter how slow the pictures are.
    const calm = varied(["change.plant.disturbance.disturbance.force", [0, 0, 0]], ["change.duration", 60]);
    const { page, errors } = await open(chrome, `${host.address}${B}${calm}&speed=10`);
    const wall = "wall";
    await page.click("#play");
    await until(page, 8);
    await page.selectOption("#speed", "1");
    const { normal } = await page.evaluate((name) => window.wbqp.about().walls.find((w) => w.name === name), wall);
    const before = { wall: await field(page, `wall/${wall}`), tip: await field(page, "contact/tip/point") };
    const box = await page.locator("#stage canvas").boundingBox();
    const [x, y] = await page.evaluate((name) => window.wbqp.whereIs(name), wall);
    const [fromX, fromY] = [box.x + x, box.y + y];
    await page.mouse.move(fromX, fromY);
    await page.mouse.down();
    await page.mouse.move(fromX + 40, fromY + 10, { steps: 10 });
    await page.waitForTimeout(300);
    await page.screenshot({ path: join(pictures, "wall-dragged.png") });
    await page.mouse.up();
    const moved = (await field(page, `wall/${wall}`)).map((p, i) => p - before.wall[i]);
    const along = moved.reduce((sum, p, i) => sum + p * normal[i], 0);
    assert.ok(Math.abs(along) > 0.01, `${moved}`);
    assert.ok(
      moved.every((p, i) => Math.abs(p - along * normal[i]) < 1e-9),
      `${moved}`,
    );
    // At the scenario's end it has long pushed again, at the new place.
    await page.selectOption("#speed", "Infinity");
    await until(page, 59.999);
    const force = -(await field(page, "contact/tip/true"))[0];
    assert.ok(Math.abs(force - 5) < 0.5, `${force}`);
    const tip = await field(page, "contact/tip/point");
    const followed = tip.reduce((sum, p, i) => sum + (p - before.tip[i]) * normal[i], 0);
    assert.ok(Math.abs(followed - along) < 0.1 * Math.abs(along), `${followed} ${along}`);
    // A link has it.
    await page.waitForFunction(() => location.hash.includes("walls"));
    const again = await open(chrome, page.url());
    const there = await field(again.page, `wall/${wall}`);
    assert.ok(
      there.every((p, i) => Math.abs(p - before.wall[i] - moved[i]) < 1e-3),
      `${there}`,
    );
    await again.page.close();
    assert.deepEqual(errors, []);
    await page.close();
  });

  test("what diverges stops with words", async () => {
    const changes = encodeURIComponent(
      JSON.stringify([{ do: "set", of: "base_orientation", keys: { kp: 3000000, kd: 0 } }]),
    );
    const { page } = await open(chrome, `${host.address}${B}&changes=${changes}&speed=10`);
    await page.click("#play");
    await page.waitForFunction(() => /diverged/.test(document.querySelector("#say").textContent), null, {
      timeout: 60_000,
    });
    assert.equal(await page.locator("#level").textContent(), "stopped");
    await page.close();
  });

  test("a broken TOML shows its message at its line", async () => {
    const { page, errors } = await open(chrome, host.address + B);
    await page.click("#edit");
    await page.waitForSelector("#editor[open] .cm-content");
    await page.locator("#tabs button[data-tab=controller]").click();
    const line = await page.evaluate(() => {
      const lines = [...document.querySelectorAll(".cm-line")].map((l) => l.textContent);
      return lines.findIndex((text) => text.startsWith("kp = 9.0")) + 1;
    });
    assert.ok(line > 0);
    await page
      .locator(".cm-line")
      .nth(line - 1)
      .click();
    await page.keyboard.press("Home");
    await page.keyboard.type("x");
    await page.keyboard.press("Escape");
    await page.locator("#apply").click();
    await page.waitForSelector("#refusal:not([hidden])");
    assert.match(
      await page.locator("#refusal").textContent(),
      new RegExp(`controller.toml:${line}:1: .*unknown key .xkp.*`),
    );
    await page.waitForSelector(".cm-lint-marker-error");
    await page.screenshot({ path: join(pictures, "broken.png") });
    // Completion comes from the schema.
    await page
      .locator(".cm-line")
      .nth(line - 1)
      .click();
    await page.keyboard.press("Home");
    await page.keyboard.press("Delete");
    await page.keyboard.press("End");
    await page.keyboard.press("Enter");
    await page.keyboard.type("integ");
    await page.waitForSelector(".cm-tooltip-autocomplete");
    assert.match(await page.locator(".cm-tooltip-autocomplete").textContent(), /integral_limit/);
    assert.deepEqual(errors, []);
    await page.close();
  });

  test("a log replays", async () => {
    const { page, errors } = await open(chrome, host.address + B);
    const log = await readFile(here("../../target/web-test/push_with_disturbance.mcap"));
    await choose(page, ["push.mcap", log]);
    await page.waitForFunction(() => document.body.dataset.replay, null, { timeout: 60_000 });
    await page.locator("#scrub").evaluate((scrub) => {
      scrub.value = "14";
      scrub.dispatchEvent(new Event("input"));
    });
    assert.ok(Math.abs((await field(page, "time"))[0] - 14) < 0.01);
    const force = -(await field(page, "contact/tip/true"))[0];
    assert.ok(Math.abs(force - 5) < 0.5, `${force}`);
    // Where the scenario has sent it, against the wall.
    assert.deepEqual([...(await field(page, "reference/base_position"))], [-0.0688, 0, 1.258]);
    assert.deepEqual([...(await field(page, "task/base_position/alpha"))], [1]);
    await page.waitForTimeout(300);
    // Nothing of a scenario that is not shown is left, and nothing to change.
    assert.equal(await page.$eval("#scenario", (choice) => choice.selectedOptions[0].textContent), "Log: push.mcap");
    assert.equal(await page.$eval("#case", (choice) => choice.textContent), "with ft");
    for (const what of ["#side", "#seed", "#edit", "#measure", "#link"]) assert.ok(!(await page.isVisible(what)), what);
    const wide = await page.$eval("#view", (view) => view.clientWidth);
    assert.ok(wide > 1390, `${wide}`);
    await page.screenshot({ path: join(pictures, "replay.png") });
    await page.click("#play");
    await until(page, 14.5);
    // Out of the log again.
    await page.selectOption("#scenario", "push_away");
    await page.waitForFunction(() => !document.body.dataset.replay);
    const offered = await page.$$eval("#scenario option", (options) => options.map((option) => option.textContent));
    assert.ok(!offered.some((name) => name.startsWith("Log")), `${offered}`);
    assert.equal(await page.inputValue("#scenario"), "push_away");
    assert.ok(await page.isVisible("#side"));
    assert.deepEqual(errors, []);
    await page.close();
  });

  test("bad files and links are words on the page, which goes on", async () => {
    const { page } = await open(chrome, host.address + B);
    const log = await readFile(here("../../target/web-test/push_with_disturbance.mcap"));
    await choose(page, ["cut.mcap", log.subarray(0, log.length / 2)]);
    await page.waitForFunction(() => /cut.mcap cannot be read/.test(document.querySelector("#problem").textContent));
    await choose(page, ["noise.mcap", "this is no log"]);
    await page.waitForFunction(() => /noise.mcap cannot be read/.test(document.querySelector("#problem").textContent));
    await choose(page, ["what.txt", "?"]);
    assert.match(await problem(page), /a log ends in .mcap/);
    await choose(page, ["bad.urdf", "<robot name='x'><link name='a'/><joint name='j' type='revolute'/></robot>"]);
    await page.waitForFunction(() => /bad.urdf/.test(document.querySelector("#problem").textContent));
    await page.selectOption("#scenario", "push_away");
    await page.waitForFunction(() => document.body.dataset.loaded === "push_away");
    await page.click("#play");
    await until(page, 0.1);
    await page.close();
    for (const hash of [
      "#scenario=nowhere",
      "#scenario=push_away&changes=%5B",
      `${B}&changes=${encodeURIComponent('[{"do":"entry","of":"x","on":true}]')}`,
    ]) {
      const { page, errors } = await open(chrome, host.address + hash);
      assert.ok(await page.locator("#problem").isVisible(), hash);
      assert.deepEqual(errors, []);
      await page.close();
    }
  });

  test("a robot of one's own holds its posture", async () => {
    const { page } = await open(chrome, host.address + B);
    const urdf = `<robot name="arm">
      <link name="ground"/>
      <link name="upper"><inertial><origin xyz="0 0 -0.2"/><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
        <visual><origin xyz="0 0 -0.2"/><geometry><cylinder radius="0.04" length="0.4"/></geometry></visual></link>
      <joint name="shoulder" type="revolute"><parent link="ground"/><child link="upper"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/>
        <limit lower="-2" upper="2" velocity="5" effort="20"/></joint>
    </robot>`;
    await choose(page, ["arm.urdf", urdf]);
    await page.waitForFunction(() => document.body.dataset.loaded === "own", null, { timeout: 20_000 });
    await page.click("#play");
    await until(page, 0.5);
    assert.ok(Math.abs((await field(page, "joints"))[0]) < 0.05);
    await page.close();
  });

  test("what matters in this tick is told while it is open, and only then", async () => {
    // However slow the pictures are, it stops while the robot is pulled.
    const { page, errors } = await open(chrome, `${host.address}${B}${varied(["change.duration", 12.5])}`);
    const told = () => page.evaluate(() => window.wbqp.matters());
    await page.click("#play");
    await until(page, 1);
    assert.equal(await told(), null);
    await page.click("#matters summary");
    await page.selectOption("#speed", "10");
    await until(page, 12.499);
    await page.waitForFunction(() => window.wbqp.matters()?.time > 12.49);
    // It is of the last tick, which began a period before.
    const [time] = await field(page, "time");
    const matters = await told();
    assert.ok(Math.abs(matters.time - time) < 0.0041, `${matters.time} ${time}`);
    const rows = page.locator("#matters ol li");
    assert.equal(await rows.count(), 6);
    const widths = await page.$$eval("#matters .bar", (bars) => bars.map((bar) => bar.getBoundingClientRect().width));
    assert.ok(
      widths.every((w, i) => w > 0 && (i === 0 || w <= widths[i - 1])),
      `${widths}`,
    );
    const [first] = matters.effects;
    const text = await rows.first().textContent();
    assert.ok(text.startsWith(`${first.owner} ${first.key.replace(/_/g, " ")}`), text);
    assert.match(text, /rotor \d effort [+−][\d.]+ N$/);
    assert.match(await rows.first().getAttribute("title"), /10 % more of it .* N, .*\/s²; all efforts/);
    // Its rotors are at their limits then.
    assert.match(await page.locator("#matters .body").textContent(), /Limits that hold it/);
    await page.screenshot({ path: join(pictures, "matters.png") });
    // A tick is told at once, and a new run begins anew.
    await page.click("#step");
    await page.waitForFunction((before) => window.wbqp.matters().time > before, matters.time);
    await page.click("#reset");
    await page.waitForFunction(() => window.wbqp.matters().time === null);
    assert.match(await page.locator("#matters .body").textContent(), /From the next tick on/);
    // Closed, nobody asks.
    await page.click("#matters summary");
    await page.selectOption("#speed", "10");
    await page.click("#play");
    await until(page, 2);
    assert.equal((await told()).time, null);
    assert.deepEqual(errors, []);
    await page.close();
  });

  test("what matters fits on a phone, and says why there are no derivatives", async () => {
    const size = { width: 390, height: 844 };
    const { page, errors } = await open(chrome, `${host.address}${B}`, size);
    await page.click("#play");
    await until(page, 0.5);
    await page.click("#matters summary");
    await page.waitForSelector("#matters ol li");
    await page.locator("#matters").scrollIntoViewIfNeeded();
    const outside = await page.$$eval("#matters *", (all) => {
      const most = document.documentElement.clientWidth;
      return all.map((e) => e.getBoundingClientRect()).filter((box) => box.left < 0 || box.right > most + 0.5).length;
    });
    assert.equal(outside, 0);
    await page.screenshot({ path: join(pictures, "matters-phone.png") });
    assert.deepEqual(errors, []);
    await page.close();
    const stiff = varied(["set.contact.fl.force_min", 29]);
    const other = await open(chrome, `${host.address}#scenario=quadruped_stand${stiff}`, size);
    await other.page.click("#matters summary");
    await other.page.click("#play");
    await other.page.waitForFunction(() => window.wbqp.matters()?.refused, null, { timeout: 60_000 });
    assert.match(await other.page.locator("#matters .body").textContent(), /No derivatives here: .* optimum/);
    await other.page.close();
  });

  test("works on a phone, and with a keyboard alone", async () => {
    const { page, errors } = await open(chrome, host.address + B, { width: 390, height: 844 });
    await page.keyboard.press("Space");
    await until(page, 0.3);
    const width = await page.evaluate(() => document.documentElement.scrollWidth);
    assert.ok(width <= 390, `${width}`);
    await page.screenshot({ path: join(pictures, "phone.png") });
    await page.screenshot({ path: join(pictures, "phone-all.png"), fullPage: true });
    // Everything that can be pressed has a name.
    const nameless = await page.$$eval("button, input, select, canvas", (list) =>
      list
        .filter(
          (e) =>
            e.offsetParent !== null &&
            !e.textContent.trim() &&
            !e.getAttribute("aria-label") &&
            !e.closest("label") &&
            !e.title,
        )
        .map((e) => e.outerHTML.slice(0, 120)),
    );
    assert.deepEqual(nameless, []);
    assert.deepEqual(errors, []);
    await page.close();
  });
});
