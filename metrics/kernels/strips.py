"""Strips of rows that threads take one after another in native code: between two of them nobody waits for Python.

A kernel's first argument is the first row of its strip. Whoever leads wakes helpers, takes strips and waits for those
who have woken; a helper takes strips whenever it is woken. What they share in memory C declares as Python does.
"""

import ctypes

import warp as wp


class Strips(ctypes.Structure):
    """Strips of a launch: rows `begin` ... `end`, `height` of each but the last.

    function: the kernel's. each, last: bounds of a strip of all its rows and of the last one. taken: how many were.
    """

    _fields_ = (
        ("function", ctypes.c_void_p),
        ("each", ctypes.c_void_p),
        ("last", ctypes.c_void_p),
        ("begin", ctypes.c_int32),
        ("end", ctypes.c_int32),
        ("height", ctypes.c_int32),
        ("taken", ctypes.c_int32),
    )


class Helper(ctypes.Structure):
    """What a thread that helps and who leads it both know.

    wake, done: locks, which are free only when it is asked for something, and has done it. strips, arguments: of a
    launch, null for it to end. next: another one that helps with it. idle: whether it is there, and nobody leads it.
    serves: whether it is to go on.
    """

    _fields_ = (
        ("wake", ctypes.c_void_p),
        ("done", ctypes.c_void_p),
        ("strips", ctypes.c_void_p),
        ("arguments", ctypes.c_void_p),
        ("next", ctypes.c_void_p),
        ("idle", ctypes.c_int32),
        ("serves", ctypes.c_int32),
    )


IN_C = {ctypes.c_void_p: "void*", ctypes.c_int32: "int"}


def declared(structure: type[Strips | Helper]) -> str:
    """A structure's declaration in C."""
    fields = "".join(f" {IN_C[kind]} {name};" for name, kind in structure._fields_)
    return f"struct {structure.__name__} {{{fields} }};"


TYPES = (
    declared(Strips)
    + declared(Helper)
    + """
    using Acquire = auto (void*, int) -> int;
    using Release = auto (void*) -> void;
    const auto take = [](Strips* strips, void* arguments) {
        for (;;) {
            const int strip = __atomic_fetch_add(&strips->taken, 1, __ATOMIC_RELAXED);
            const int first = strips->begin + strips->height*strip, left = strips->end - first;
            if (left <= 0) return;
            *(int*)arguments = first;
            ((void (*)(void*, void*))strips->function)(left < strips->height ? strips->last : strips->each, arguments);
        }
    };
    const auto claim = [](Helper* helper) {
        int idle = 1;
        return __atomic_compare_exchange_n(&helper->idle, &idle, 0, false, __ATOMIC_SEQ_CST, __ATOMIC_SEQ_CST);
    };
    const auto dismiss = [claim](Helper* helper, Release* release) {
        if (!claim(helper)) return;
        helper->strips = nullptr;
        release(helper->wake);
    };
"""
)

LEAD = """
    void** own = (void**)arguments;
    Helper* mine = nullptr;
    for (Helper* helper = (Helper*)helpers; helper < (Helper*)helpers + count && asked > 0; ++helper) {
        if (!claim(helper)) continue;
        helper->strips = (void*)strips;
        helper->arguments = own[asked--];
        helper->next = mine;
        mine = helper;
        ((Release*)release)(helper->wake);
    }
    take((Strips*)strips, own[0]);
    while (mine) {
        Helper* const helper = mine;
        mine = (Helper*)helper->next;
        // Who has not woken by now finds nothing left, and sleeps on.
        if (!((Acquire*)acquire)(helper->wake, 0)) ((Acquire*)acquire)(helper->done, 1);
        __atomic_store_n(&helper->idle, 1, __ATOMIC_SEQ_CST);
        if (!__atomic_load_n(&helper->serves, __ATOMIC_SEQ_CST)) dismiss(helper, (Release*)release);
    }
"""

SERVE = """
    Helper* const helper = (Helper*)own;
    for (;;) {
        ((Acquire*)acquire)(helper->wake, 1);
        if (!helper->strips) return;
        take((Strips*)helper->strips, helper->arguments);
        ((Release*)release)(helper->done);
    }
"""

DISMISS = """
    for (Helper* helper = (Helper*)helpers; helper < (Helper*)helpers + count; ++helper) {
        __atomic_store_n(&helper->serves, 0, __ATOMIC_SEQ_CST);
        dismiss(helper, (Release*)release);
    }
"""


@wp.func_native(TYPES + LEAD)
def take_together(
    strips: wp.uint64,
    arguments: wp.uint64,
    asked: wp.int32,
    helpers: wp.uint64,
    count: wp.int32,
    acquire: wp.uint64,
    release: wp.uint64,
):
    """See `lead`."""


@wp.kernel(enable_backward=False)
def lead(
    strips: wp.uint64,
    arguments: wp.uint64,
    asked: wp.int32,
    helpers: wp.uint64,
    count: wp.int32,
    acquire: wp.uint64,
    release: wp.uint64,
):
    """Take strips, as helpers do that are woken for it, and wait for these. All are given by where they are in memory.

    arguments: where those of the calling thread are, and those for each of the helpers that are asked for at most.
    helpers: so many, some of which may be helping others. acquire, release: what acquires and releases a lock.
    """
    take_together(strips, arguments, asked, helpers, count, acquire, release)


@wp.func_native(TYPES + SERVE)
def take_when_woken(own: wp.uint64, acquire: wp.uint64, release: wp.uint64):
    """See `serve`."""


@wp.kernel(enable_backward=False)
def serve(own: wp.uint64, acquire: wp.uint64, release: wp.uint64):
    """Be a helper: take strips whenever it is woken, until there are none for it."""
    take_when_woken(own, acquire, release)


@wp.func_native(TYPES + DISMISS)
def dismiss_all(helpers: wp.uint64, count: wp.int32, release: wp.uint64):
    """See `dismiss`."""


@wp.kernel(enable_backward=False)
def dismiss(helpers: wp.uint64, count: wp.int32, release: wp.uint64):
    """Have helpers end: now who is idle, others as soon as nobody leads them."""
    dismiss_all(helpers, count, release)
