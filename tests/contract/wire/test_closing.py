from typing import get_args

from contract.wire.close_reasons import (
    CLOSE_REASONS,
    CloseCode,
    close_reason,
    close_reason_of_number,
)


def test_every_closing_code_has_one_row_and_one_number() -> None:
    assert {row.code for row in CLOSE_REASONS} == set(get_args(CloseCode))
    assert len({row.number for row in CLOSE_REASONS}) == len(CLOSE_REASONS)
    assert all(4000 <= row.number <= 4999 for row in CLOSE_REASONS)


def test_a_number_leads_back_to_its_row_and_foreign_numbers_to_none() -> None:
    for row in CLOSE_REASONS:
        assert close_reason_of_number(row.number) is close_reason(row.code) is row
    assert close_reason_of_number(1006) is None


def test_every_row_says_what_to_do() -> None:
    assert all(len(row.advice) > 20 for row in CLOSE_REASONS)
