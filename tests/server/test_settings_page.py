from docs.settings_page import PAGE, page
from server.settings import Settings


def test_the_page_of_the_settings_is_what_their_types_say() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "run `python -m docs.settings_page`"


def test_every_setting_has_a_description() -> None:
    assert [name for name, field in Settings.model_fields.items() if not field.description] == []
