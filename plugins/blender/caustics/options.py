# SPDX-License-Identifier: Apache-2.0
"""What a run is asked for: from the scene's panel, from a script, or from a command line."""
import os

from .errors import CausticsError

QUALITY = {"DRAFT": 0.2, "GOOD": 0.05, "FINAL": 0.02}
BEAUTY = ("RENDER", "LAST", "NONE")


class Options:
    """quality: DRAFT, GOOD, FINAL or an error (RMSE over RMS, e.g. 0.05). time_s: at most so many seconds, 0 for no limit.
    photons: per light in place of both, 0 for none. beauty: RENDER it, take the LAST render, NONE (layers only). indirect:
    AUTO, ON, OFF. in_process: the renderer inside Blender (inprocess.py). output: path of the result without its ending. threads, memory ("2G"), seed: as of caustic-render."""

    def __init__(self, output, quality="GOOD", time_s=600.0, photons=0, beauty="RENDER", indirect="AUTO", seed=0, threads=0,
                 memory="", error_layers=False, irradiance=False, full_float=True, keep_beauty=False, keep_report=False, pointers=True,
                 estimator="", in_process=False):
        if isinstance(quality, str) and quality.upper() in QUALITY:
            self.error = QUALITY[quality.upper()]
        else:
            self.error = as_number("quality", quality, 1e-4, 10.0)
        if beauty not in BEAUTY:
            raise CausticsError(f"beauty is \"{beauty}\"; it must be one of {', '.join(BEAUTY)}.")
        self.output = os.path.splitext(output)[0] if output.endswith(".exr") else output
        self.time_s, self.photons = as_number("time", time_s, 0, 1e9), int(as_number("photons", photons, 0, 1e15))
        if self.photons:
            self.error = self.time_s = 0
        self.beauty, self.indirect, self.seed, self.threads = beauty, indirect, int(seed), int(threads)
        self.memory_bytes = as_bytes(memory)
        self.memory, self.error_layers, self.irradiance, self.full_float = memory, error_layers, irradiance, full_float
        self.keep_beauty, self.keep_report, self.pointers, self.estimator = keep_beauty, keep_report, pointers, estimator
        self.in_process = in_process

    def layers(self, albedo):
        """The kinds of layers that are wanted."""
        return ["radiance"] + ["irradiance"] * (albedo or self.irradiance) + ["error"] * self.error_layers

    def words(self, extract, albedo):
        """Of the command line of caustic-render."""
        words = ["--progress", "--explain", "--seed", str(self.seed)]
        for option, value in (("--photons", self.photons), ("--error", self.error), ("--time", self.time_s), ("--threads", self.threads),
                              ("--memory", self.memory), ("--estimator", self.estimator)):
            if value:
                words += [option, str(value)]
        if self.indirect != "AUTO":
            words += ["--effects", "direct,indirect" if self.indirect == "ON" else "direct"]
        layers = self.layers(albedo)
        if len(layers) > 1:
            words += ["--layers", ",".join(layers)]
        if extract.region:
            words += ["--region", ",".join(str(x) for x in extract.region)]
        return words

    def path(self, suffix, ending=".exr"):
        return self.output + suffix + ending

    def frame(self, number):
        """The same for one frame of a sequence."""
        import copy
        made = copy.copy(self)
        made.output = f"{self.output}_{number:04d}"
        return made


def as_bytes(text):
    """0 where none is given."""
    units = {"": 1, "K": 1 << 10, "M": 1 << 20, "G": 1 << 30}
    digits = text.rstrip("KMGkmg")
    unit = units.get(text[len(digits):].upper())
    if not text:
        return 0
    if unit is None or not digits.isdigit() or int(digits) * unit < 1 << 20:
        raise CausticsError(f'memory is "{text}"; it must be a size of at least 1M, e.g. 512M.')
    return int(digits) * unit


def as_number(name, value, low, high):
    try:
        x = float(value)
    except (TypeError, ValueError):
        x = float("nan")
    if not low <= x <= high:
        raise CausticsError(f"{name} is {value}; it must be a number from {low:g} to {high:g}.")
    return x
