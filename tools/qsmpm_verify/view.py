"""`view`: a body coloured by a field of its material points, with its initial and current outline; one step or all steps.

`--mechanism` shows the failure mechanism of a safety phase: the magnitude of its displacements has no meaning, so they are relative to
their largest value.
"""

from __future__ import annotations

import argparse
from importlib import util
from pathlib import Path

import numpy as np

from qsmpm_verify.bodies import body_of, frame_of, is_flat, start_of
from qsmpm_verify.fields import NAMES, scalar_field, title_of, unit_of
from qsmpm_verify.paraview import pieces_of
from qsmpm_verify.plane_picture import plane_picture
from qsmpm_verify.results import (
    Array, Points, ResultError, phase_of_steps, read_mechanism, read_mesh, read_points, written_mechanisms, written_steps,
)
from qsmpm_verify.told import factor_text, phase_name, phase_number, read_phase
from qsmpm_verify.trouble import Trouble


def add_words(verbs: argparse._SubParsersAction) -> None:
    """Arguments of the subcommand."""
    verb = verbs.add_parser(
        "view", help="draw the material points of a run coloured by a field, or an animation of its steps"
    )
    verb.add_argument("result", type=Path, help="folder of a run, or its results.h5")
    verb.add_argument("--field", default="displacement", help=f"one of {', '.join(NAMES)}; default displacement")
    verb.add_argument("--step", type=int, help="step to draw; default the last one written")
    verb.add_argument("--phase", type=read_phase, help="last step written of a phase, or its animation; by name or number")
    verb.add_argument("--mechanism", action="store_true", help="failure mechanism of the last safety phase, or of --phase")
    verb.add_argument("--film", action="store_true", help="animation of all written steps")
    verb.add_argument(
        "--range", nargs=2, type=float, metavar=("LEAST", "MOST"), help="limits of the colour scale"
    )
    verb.add_argument("--mesh", action="store_true", help="edges of the cells in the initial geometry")
    verb.add_argument("--no-outline", action="store_true", help="omit the outline of the body")
    verb.add_argument("--rate", type=float, default=8.0, help="frames per second of an animation")
    verb.add_argument("--out", type=Path, default=Path("view.png"), help=".png, or .gif or .mp4 for an animation")
    verb.set_defaults(act=act)


def chosen_steps(words: argparse.Namespace) -> list[int]:
    """The steps to draw."""
    if words.result.suffix in (".vtu", ".pvd"):
        raise Trouble(f"{words.result}: view requires the folder of a run or its results.h5; open this file in ParaView")
    written = written_steps(words.result)
    if not written:
        raise ResultError(f"{words.result}: no step has been written")
    if words.phase is not None:
        number = phase_number(folder_of(words.result), words.phase)
        written = [step for step, phase in phase_of_steps(words.result).items() if phase == number]
        if not written:
            raise ResultError(f"{words.result}: no step of phase {words.phase} has been written")
    if words.film:
        return written
    step = written[-1] if words.step is None else words.step
    if step not in written:
        shown = ", ".join(map(str, written[:12])) + (" ..." if len(written) > 12 else "")
        raise ResultError(f"{words.result}: the points of step {step} have not been written; available are {shown}")
    return [step]


def spacing_of(points: Points) -> float:
    """Spacing of neighbours in 3D, from the initial volume of the largest point."""
    return float(points.field("initial_volume").max()) ** (1 / 3)


def neighbours(start: Array) -> float:
    """Largest distance of a point from its nearest neighbour on a sample of points."""
    sample = start[np.linspace(0, len(start) - 1, min(len(start), 60)).astype(int)]
    gaps = np.linalg.norm(sample[:, None, :] - start[None, :, :], axis=2)
    gaps[gaps == 0] = np.inf
    return float(gaps.min(axis=1).max())


def job_of(folder: Path) -> str:
    """Name of the run: that of its echoed deck, or that of the folder."""
    echoed = sorted(folder.glob("*.echo.inp"))
    return echoed[0].name.removesuffix(".echo.inp") if echoed else folder.resolve().name


def plane_frames(states: list[Points], values: list[Array], title: str, words: argparse.Namespace, job: str) -> list[Array]:
    """Figures of a plane body: the field up to its boundary."""
    frame, mesh = frame_of(states, values, words.field, title, words.range or ()), read_mesh(words.result)
    return [
        plane_picture(body_of(points, value, mesh), frame, caption_of(job, points, words), not words.no_outline,
                      mesh if words.mesh else None)
        for points, value in zip(states, values)
    ]  # fmt: skip


def caption_of(job: str, points: Points, words: argparse.Namespace) -> str:
    """Caption of a figure."""
    folder = folder_of(words.result)
    state = f"step {points.step}, load factor {points.load_factor:.4g}"
    parts = (f"{job}: phase {phase_name(folder, points.phase)}", "failure mechanism" if words.mechanism else state,
             factor_text(folder, points.phase))
    return ", ".join(part for part in parts if part)


def space_frames(states: list[Points], values: list[Array], title: str, words: argparse.Namespace, job: str) -> list[Array]:
    """Figures of a 3D body: its surface coloured by the field; points that have separated from it as spheres."""
    if not util.find_spec("vtkmodules"):
        raise Trouble("view of a 3D body requires the Python package vtk: run tools/setup")
    from qsmpm_verify import stage
    from qsmpm_verify.solid_skin import skins_of

    start = start_of(states[0])
    places = [points.field("position") for points in states]
    everything = np.concatenate([start, *places])
    least, most = words.range or (min(v.min() for v in values), max(v.max() for v in values))
    margin = 0.02 * float(np.ptp(everything, axis=0).max())
    look = stage.Look.around(everything.min(axis=0) - margin, everything.max(axis=0) + margin, least, most)
    spacing = spacing_of(states[0])
    outline = None if words.no_outline else stage.hull(start, max(spacing, 1.2 * neighbours(start)))
    mesh = read_mesh(words.result) if words.mesh else None
    return [
        stage.picture(look, place, value, spacing, f"{caption_of(job, points, words)}, {title}",
                      skins_of(start_of(points), place, points.fields.get("material", np.zeros(len(place)))),
                      pieces_of(points, 1.0), outline, mesh)
        for points, place, value in zip(states, places, values)
    ]


def folder_of(result: Path) -> Path:
    """Folder of a run, given directly or by its results.h5."""
    return result if result.is_dir() else result.parent


def frames(words: argparse.Namespace, steps: list[int]) -> list[Array]:
    """Figures of the steps, all with the same colour scale and viewpoint."""
    states = [read_points(words.result, step) for step in steps]
    values = [scalar_field(points, words.field) for points in states]
    unit = unit_of(folder_of(words.result), words.field)
    return drawn(states, values, f"{title_of(words.field)} [{unit}]" if unit else title_of(words.field), words)


def drawn(states: list[Points], values: list[Array], title: str, words: argparse.Namespace) -> list[Array]:
    """Figures of states."""
    draw = plane_frames if is_flat(states) else space_frames
    return draw(states, values, title, words, job_of(folder_of(words.result)))


def mechanism(words: argparse.Namespace) -> Array:
    """Figure of the failure mechanism."""
    there = written_mechanisms(words.result)
    number = None if words.phase is None else phase_number(folder_of(words.result), words.phase)
    if not there or number not in (None, *there):
        known = ", ".join(phase_name(folder_of(words.result), n) for n in there) or "none"
        raise ResultError(f"{words.result}: no mechanism of {'any phase' if number is None else f'phase {words.phase}'}; "
                          f"available are: {known} (*PHASE, TYPE=SAFETY writes them)")
    points = read_mechanism(words.result, number)
    values = scalar_field(points, words.field)
    title = title_of(words.field)
    if "displacement" in words.field or "strain" in words.field:
        values, title = values / max(float(np.abs(values).max()), 1e-300), f"{title} / largest value"
    return drawn([points], [values], title, words)[0]


def write_picture(picture: Array, out: Path) -> Path:
    """One PNG file."""
    from PIL import Image

    out.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(picture).save(out, optimize=True)
    return out


def last_state(result: Path, field: str, out: Path) -> Path:
    """Figure of the last state of a run with default options."""
    words = argparse.Namespace(result=result, field=field, range=None, no_outline=False, mesh=False, mechanism=False)
    return write_picture(frames(words, written_steps(result)[-1:])[0], out)


def write_film(pictures: list[Array], out: Path, rate: float) -> list[Path]:
    """A GIF, an MP4 if imageio can write one, otherwise a series of PNG files."""
    from PIL import Image

    out.parent.mkdir(parents=True, exist_ok=True)
    if out.suffix == ".gif":
        images = [Image.fromarray(p).quantize(colors=128) for p in pictures]
        images[0].save(out, save_all=True, append_images=images[1:], duration=1000 / rate, loop=0, optimize=True)
        return [out]
    if out.suffix == ".mp4" and util.find_spec("imageio") and util.find_spec("imageio_ffmpeg"):
        import imageio.v2 as imageio

        with imageio.get_writer(out, fps=rate) as writer:
            for picture in pictures:
                writer.append_data(picture)
        return [out]
    names = [out.with_name(f"{out.stem}_{count:04d}.png") for count in range(len(pictures))]
    for name, picture in zip(names, pictures):
        Image.fromarray(picture).save(name)
    return names


def act(words: argparse.Namespace) -> int:
    """Draw and report the files written."""
    if words.out.suffix not in ((".png", ".gif", ".mp4") if words.film else (".png",)):
        raise Trouble(f"{words.out}: a figure must be a .png file; an animation (--film) a .gif or .mp4 file, or .png for a series")
    if words.rate <= 0:
        raise Trouble("--rate must be above zero")
    if words.range and not words.range[0] < words.range[1]:
        raise Trouble("--range requires the lower value first")
    if words.mechanism and (words.film or words.step is not None):
        raise Trouble("--mechanism is a single state of a phase and cannot be combined with --film or --step")
    pictures = [mechanism(words)] if words.mechanism else frames(words, chosen_steps(words))
    if words.film:
        written = write_film(pictures, words.out, words.rate)
        if len(written) > 1 and words.out.suffix == ".mp4":
            print("imageio with ffmpeg is not installed: a series of PNG files is written instead of the MP4")
    else:
        written = [write_picture(pictures[0], words.out)]
    print(written[0] if len(written) == 1 else f"{written[0]} to {written[-1].name}")
    return 0
