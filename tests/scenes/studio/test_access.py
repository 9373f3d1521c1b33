"""Who is let in, and who is not."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes.studio.access import Access, new_token, read_cookie

ACCESS = Access(port=8123, token="a-good-token")
COOKIE = f"{ACCESS.cookie_name}=a-good-token; other=1"
OWN = {"Host": "127.0.0.1:8123", "Origin": "http://127.0.0.1:8123", "Cookie": COOKIE}


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost"])
def test_the_studios_own_page_is_let_in(name):
    headers = {"Host": f"{name}:8123", "Origin": f"http://{name}:8123", "Cookie": COOKIE}
    assert ACCESS.refusal(headers, origin_needed=True) is None


def test_the_printed_address_is_let_in_from_anywhere():
    headers = {"Host": "127.0.0.1:8123", "Sec-Fetch-Site": "cross-site"}
    assert ACCESS.refusal(headers, query_token="a-good-token") is None
    assert ACCESS.url == "http://127.0.0.1:8123/?token=a-good-token"


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"Host": "evil.example:8123"}, "host"),
        ({"Host": "127.0.0.1:8124"}, "host"),
        ({"Host": "127.0.0.1"}, "host"),
        ({"Host": "127.0.0.1:8123.evil.example"}, "host"),
        ({"Host": ""}, "host"),
        ({"Origin": "http://evil.example"}, "another page"),
        ({"Origin": "https://127.0.0.1:8123"}, "another page"),
        ({"Origin": "http://127.0.0.1:8888"}, "another page"),
        ({"Origin": "http://127.0.0.1:8123@evil.example"}, "another page"),
        ({"Origin": "null"}, "another page"),
        ({"Sec-Fetch-Site": "cross-site"}, "another page"),
        ({"Sec-Fetch-Site": "same-site"}, "another page"),
        ({"Cookie": ""}, "token"),
        ({"Cookie": f"{ACCESS.cookie_name}=a-good-toke"}, "token"),
        ({"Cookie": "lce_studio_8124=a-good-token"}, "token"),
    ],
)
def test_others_are_refused(change, reason):
    refused = ACCESS.refusal({**OWN, **change})
    assert refused is not None
    assert reason in refused


def test_what_changes_something_needs_an_origin():
    headers = {name: value for name, value in OWN.items() if name != "Origin"}
    assert ACCESS.refusal(headers) is None
    assert ACCESS.refusal(headers, origin_needed=True) is not None


def test_a_right_token_in_the_address_does_not_open_the_door_to_another_page():
    assert ACCESS.refusal({**OWN, "Origin": "http://evil.example"}, query_token="a-good-token") is not None
    assert ACCESS.refusal({**OWN, "Host": "evil.example"}, query_token="a-good-token") is not None


@settings(max_examples=30)
@given(st.text())
def test_only_the_token_is_the_token(text):
    assert ACCESS.is_token(text) == (text == "a-good-token")
    assert (ACCESS.refusal(OWN, query_token=text) is None) == (text == "a-good-token")


@settings(max_examples=30)
@given(st.text())
def test_no_cookie_header_breaks_the_door(text):
    found = read_cookie({"Cookie": text}, "name")
    assert found is None or isinstance(found, str)


def test_tokens_are_long_and_new_each_time_and_not_told():
    assert len({new_token() for _ in range(100)}) == 100
    assert len(new_token()) >= 32
    assert "a-good-token" not in repr(ACCESS)
