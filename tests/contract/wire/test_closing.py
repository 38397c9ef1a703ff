from typing import get_args

from contract.wire.closing import CLOSINGS, ClosingCode, closing, closing_of_number


def test_every_closing_code_has_one_row_and_one_number() -> None:
    assert {row.code for row in CLOSINGS} == set(get_args(ClosingCode))
    assert len({row.number for row in CLOSINGS}) == len(CLOSINGS)
    assert all(4000 <= row.number <= 4999 for row in CLOSINGS)


def test_a_number_leads_back_to_its_row_and_foreign_numbers_to_none() -> None:
    for row in CLOSINGS:
        assert closing_of_number(row.number) is closing(row.code) is row
    assert closing_of_number(1006) is None


def test_every_row_says_what_to_do() -> None:
    assert all(len(row.advice) > 20 for row in CLOSINGS)
