"""Kernels are made once, whatever the number of threads that ask."""

import threading

import warp as wp

from metrics.kernels.making import made_once

THREADS = 8


@made_once
def scaled(factor):
    @wp.func(module="unique")
    def scale(value: wp.float32):
        return wp.static(factor) * value

    return scale


@made_once
def scaling(factor):
    scale = scaled(factor)

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(values: wp.array(dtype=wp.float32)):
        values[wp.tid()] = scale(values[wp.tid()])

    return kernel


def asked_by_many(ask):
    """What `ask` gave each of many threads that asked in the same moment."""
    start, found = threading.Barrier(THREADS), [None] * THREADS

    def run(number):
        start.wait()
        found[number] = ask()

    threads = [threading.Thread(target=run, args=(number,)) for number in range(THREADS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return found


def test_threads_that_ask_at_once_get_one_kernel():
    made = [asked_by_many(lambda factor=factor: scaling(float(factor))) for factor in range(20)]
    assert all(len({id(kernel) for kernel in kernels}) == 1 for kernels in made)
    assert len({id(kernels[0]) for kernels in made}) == len(made)


def test_one_thread_makes_at_a_time():
    making, most = [], []

    @made_once
    def thing(number):
        making.append(number)
        most.append(len(making))
        wake.wait(0.001)
        making.remove(number)
        return number

    wake = threading.Event()
    numbers = iter(range(THREADS))
    assert sorted(asked_by_many(lambda: thing(next(numbers)))) == list(range(THREADS))
    assert most == [1] * THREADS


def test_what_fails_is_made_again_when_asked_again():
    calls = []

    @made_once
    def thing():
        calls.append(None)
        if len(calls) == 1:
            raise OSError("disk full")
        return len(calls)

    try:
        thing()
    except OSError:
        assert thing() == 2
    assert thing() == 2
