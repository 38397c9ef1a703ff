"""What all maps have in common that vehicles compare their scans with."""


class LocalizationMapError(ValueError):
    """The folder holds no map that can be used; the message is one sentence."""
