"""`campusloop openapi`: the OpenAPI document, from which the web client is generated."""

import json
import sys

from server.api.routers import bare_app


def openapi() -> None:
    """Print the OpenAPI document as JSON."""
    json.dump(bare_app().openapi(), sys.stdout, indent=1, ensure_ascii=False)
    sys.stdout.write("\n")
