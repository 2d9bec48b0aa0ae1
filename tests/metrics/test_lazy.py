"""Lazy properties are made once for each object."""

from metrics.lazy import lazy


class Numbered:
    made = 0

    @lazy
    def number(self):
        """Which of all that were asked."""
        Numbered.made += 1
        return Numbered.made


def test_a_lazy_property_is_made_once_for_each_object():
    one, other = Numbered(), Numbered()
    assert [one.number, other.number, one.number] == [1, 2, 1]


def test_on_the_class_it_is_what_documents_it():
    assert Numbered.number.__doc__ == "Which of all that were asked."
