from server.travel.cached_results import CachedResults


def test_the_same_objects_give_the_kept_result() -> None:
    results, part = CachedResults(), ("a",)
    first = results.get("name", (part,), lambda: [1])
    assert results.get("name", (part,), lambda: [2]) is first


def test_an_equal_but_other_object_makes_the_result_again() -> None:
    results = CachedResults()
    results.get("name", ([1],), lambda: "first")
    assert results.get("name", ([1],), lambda: "second") == "second"


def test_names_do_not_share_results() -> None:
    results, part = CachedResults(), ("a",)
    results.get("one", (part,), lambda: "first")
    assert results.get("two", (part,), lambda: "second") == "second"
