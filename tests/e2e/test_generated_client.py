import json

from server.api.routers import bare_app
from tests.e2e.server_process import ROOT


def test_the_web_client_is_generated_from_the_api_as_it_is() -> None:
    kept = json.loads((ROOT / "web" / "openapi.json").read_text(encoding="utf-8"))
    now = json.loads(json.dumps(bare_app().openapi()))
    assert kept == now, "run `campusloop openapi > web/openapi.json` and `npm run types` in web/"
