"""Films of what happens in MuJoCo, drawn beside the simulation, which never sees them.

MuJoCo draws without a window if the environment says how: ``MUJOCO_GL=egl``, or ``osmesa`` with Debian's libosmesa6.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import mujoco
import numpy as np
from PIL import Image, ImageDraw, ImageFont

BLACK, GREY, RED = (0.1, 0.1, 0.1, 1.0), (0.5, 0.5, 0.5, 1.0), (0.8, 0.1, 0.1, 1.0)
BLUE, GREEN = (0.1, 0.3, 0.85, 1.0), (0.0, 0.5, 0.15, 1.0)
Colour = tuple[float, float, float, float]
Arrow = tuple[Sequence[float], Sequence[float], Colour]
"""Where a force acts, m; the arrow, m; its colour."""


class Film:
    """Frames of a simulation.

    Parameters
    ----------
    file : path or None
        Where it goes: an animation (WebP, GIF), or the last frame (PNG). Without one nothing is drawn.
    mjcf : str
        The simulated model. What has no shape in it is drawn as tubes between joints and discs for rotors.
    lookat, distance, azimuth, elevation
        Where the camera looks, m, from how far, m, and from which angles, degrees.
    floor : float
        Height of the floor that is drawn, m.
    every : float
        Simulated time between two frames, s.
    speed : float
        Simulated seconds per second of the film.
    tube : float
        Radius of what is drawn as tubes, m; that of rotors is six times as much.
    dot : float
        Radius of dots, m.
    """

    def __init__(self, file: str | Path | None, mjcf: str, *, lookat: Sequence[float], distance: float, azimuth: float,
                 elevation: float, floor: float = 0.0, every: float = 0.1, speed: float = 1.0, tube: float = 0.012,
                 dot: float = 0.006) -> None:
        self.file, self.every, self.speed, self.dot = file, every, speed, dot
        self.frames: list[Image.Image] = []
        self.next = 0.0
        if file is None:
            return
        self.model = dressed(mjcf, lookat, distance, floor, tube)
        self.data = mujoco.MjData(self.model)
        self.renderer = mujoco.Renderer(self.model, 360, 640)
        self.camera = mujoco.MjvCamera()
        self.camera.lookat[:] = lookat
        self.camera.distance, self.camera.azimuth, self.camera.elevation = distance, azimuth, elevation

    def due(self, time: float) -> bool:
        """Whether a frame should be taken at this simulated time, s."""
        return self.file is not None and time >= self.next - 1e-9

    def take(self, data: mujoco.MjData, text: Sequence[tuple[str, Colour]], arrows: Iterable[Arrow] = (),
             dots: Iterable[tuple[Sequence[float], Colour]] = ()) -> None:
        """Takes a frame: the robot, lines of text, arrows, dots (place, m)."""
        self.next = data.time + self.every
        self.data.qpos[:] = data.qpos
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)
        self.renderer.update_scene(self.data, self.camera)
        scene = self.renderer.scene
        for place, arrow, colour in arrows:
            if np.linalg.norm(arrow) > 0.01 * self.camera.distance:
                start = np.asarray(place, float)
                geom = self._add(mujoco.mjtGeom.mjGEOM_ARROW, start, colour)
                width = 0.006 * self.camera.distance
                mujoco.mjv_connector(geom, mujoco.mjtGeom.mjGEOM_ARROW, width, start, start + arrow)
        for place, colour in dots:
            self._add(mujoco.mjtGeom.mjGEOM_SPHERE, np.asarray(place, float), colour)
        assert scene.ngeom < scene.maxgeom
        image = Image.fromarray(self.renderer.render())
        pen = ImageDraw.Draw(image)
        font = ImageFont.load_default(size=18)
        for k, (line, colour) in enumerate(text):
            pen.text((12, 8 + 24 * k), line, fill=tuple(round(255 * part) for part in colour[:3]), font=font)
        self.frames.append(image)

    def _add(self, kind: mujoco.mjtGeom, place: np.ndarray, colour: Colour) -> mujoco.MjvGeom:
        scene = self.renderer.scene
        geom = scene.geoms[scene.ngeom]
        scene.ngeom += 1
        mujoco.mjv_initGeom(geom, kind, np.full(3, self.dot), place, np.eye(3).ravel(), np.array(colour, np.float32))
        geom.emission = 0.4
        return geom

    def save(self) -> None:
        """Writes the file."""
        if self.file is None:
            return
        self.renderer.close()
        if Path(self.file).suffix not in (".webp", ".gif"):
            self.frames[-1].save(self.file)
            return
        pause = round(1000.0 * self.every / self.speed)
        self.frames[0].save(self.file, save_all=True, append_images=self.frames[1:], duration=pause, loop=0, quality=50,
                            method=6)


def dressed(mjcf: str, lookat: Sequence[float], distance: float, floor: float, tube: float) -> mujoco.MjModel:
    """The model with light, floor and sky, and with shapes where it has none."""
    spec = mujoco.MjSpec.from_string(mjcf)
    kinds = mujoco.mjtGeom
    textures = mujoco.mjtTexture
    spec.add_texture(name="sky", type=textures.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
                     rgb1=[1.0, 1.0, 1.0], rgb2=[0.8, 0.87, 0.95], width=64, height=64)
    spec.add_texture(name="tiles", type=textures.mjTEXTURE_2D, builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
                     rgb1=[0.86, 0.87, 0.88], rgb2=[0.8, 0.81, 0.83], width=256, height=256)
    material = spec.add_material(name="tiles", texrepeat=[2, 2], texuniform=True)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "tiles"
    world = spec.worldbody
    # Shadows reach as far as the model is large: as far as the camera sees.
    spec.stat.center[:], spec.stat.extent = lookat, distance
    world.add_light(pos=np.add(lookat, [-0.5, -0.5, 2.0]), dir=[0.2, 0.2, -1.0],
                    type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, diffuse=[0.6] * 3, castshadow=True)
    spec.visual.headlight.ambient[:], spec.visual.headlight.diffuse[:] = 0.35, 0.35
    spec.visual.quality.shadowsize, spec.visual.map.shadowclip = 8192, 3.0
    for geom in list(world.geoms):
        if geom.type == kinds.mjGEOM_PLANE and geom.name == "wall":
            # It stands on the floor, as high as leaves room for rotors above it.
            geom.size[:2], geom.rgba = [0.95, 0.6], [0.45, 0.6, 0.75, 0.4]
        elif geom.type == kinds.mjGEOM_PLANE:
            spec.delete(geom)
    world.add_geom(name="drawn floor", type=kinds.mjGEOM_PLANE, size=[1.5 * distance, 1.5 * distance, 1],
                   pos=[lookat[0], lookat[1], floor], material="tiles", contype=0, conaffinity=0)
    if not spec.meshes:
        rotors = {a.target for a in spec.actuators if a.trntype == mujoco.mjtTrn.mjTRN_SITE}
        for body in spec.bodies[1:]:
            draw_tubes(body, rotors, tube)
    return spec.compile()


def draw_tubes(body: mujoco.MjsBody, rotors: set[str], tube: float) -> None:
    """Tubes from a body's origin to its joints and frames, discs at its rotors."""
    kinds = mujoco.mjtGeom
    ends = [child.pos for child in body.bodies]
    for site in body.sites:
        ends.append(site.pos)
        if site.name in rotors:
            body.add_geom(type=kinds.mjGEOM_CYLINDER, size=[6.0 * tube, 0.2 * tube, 0], pos=site.pos, quat=site.quat,
                          rgba=[0.2, 0.25, 0.35, 0.6], contype=0, conaffinity=0, mass=0)
    for end in ends:
        if np.linalg.norm(end) > tube:
            body.add_geom(type=kinds.mjGEOM_CAPSULE, fromto=[0, 0, 0, *end], size=[tube, 0, 0],
                          rgba=[0.9, 0.55, 0.2, 1], contype=0, conaffinity=0, mass=0)
    body.add_geom(type=kinds.mjGEOM_SPHERE, size=[1.4 * tube, 0, 0], rgba=[0.25, 0.27, 0.3, 1],
                  contype=0, conaffinity=0, mass=0)
