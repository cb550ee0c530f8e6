# SPDX-License-Identifier: Apache-2.0
"""What goes wrong, in one sentence for the user."""


class CausticsError(Exception):
    """Its text is a whole sentence: what, where, the value, the limit, what to do."""


class Cancelled(CausticsError):
    """The user stopped it."""

    def __init__(self):
        super().__init__("Cancelled; all settings are as they were.")


def written(error, place):
    """A CausticsError for an OSError of writing: a disk that is full, a folder that may not be written."""
    return CausticsError(f"{error.filename or place} cannot be written ({error.strerror or error}); make room there or choose another folder.")


class Notes:
    """What is shown beside the result: things left out or approximated, each once, by name and with the reason."""

    def __init__(self):
        self.lines = []

    def add(self, name, reason):
        line = f"{name}: {reason}"
        if line not in self.lines:
            self.lines.append(line)
