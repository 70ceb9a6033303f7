/* A scene on a Cortex-M7 without an operating system (qemu-system-arm, mps2-an500): steps, and what they cost, told by
   semihosting. STEPS and STEP_SIZE (s) come from the compiler's command line. */
#include "scene.h"

extern uint32_t _data_from[], _data[], _data_end[], _bss[], _bss_end[], _stack[];

#define SYSTICK ((volatile uint32_t *)0xE000E010)
#define CPACR   (*(volatile uint32_t *)0xE000ED88)
#define PAINT   0xA5A5A5A5u

static Scene scene;

static void call_host(uint32_t operation, const void *given)
{
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = given;

    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
}

static void tell(const char *word, uint64_t value)
{
    char text[64], *to = text;

    while (*word) *to++ = *word++;
    *to++ = ' ';
    for (int digit = 60; digit >= 0; digit -= 4) *to++ = "0123456789abcdef"[value >> digit & 15];
    *to++ = '\n';
    *to = 0;
    call_host(0x04, text);
}

static void tell_number(const char *word, double value)
{
    uint64_t bits;

    memcpy(&bits, &value, sizeof bits);
    tell(word, bits);
}

static void stop(void)
{
    static const uint32_t done[2] = {0x20026, 0};

    call_host(0x20, done);
    for (;;) continue;
}

static __attribute__((noinline)) void run(void)
{
    uint64_t ticks = 0, most = 0;
    int64_t status;

    scene_reset(&scene);
    status = scene_prepare(&scene);
    if (status == 0) status = scene_initialise(&scene, 0.0);

    for (int k = 0; k < STEPS && status == 0; k++) {
        uint32_t before = SYSTICK[2];
        status = scene_step(&scene, STEP_SIZE);
        uint32_t took = (before - SYSTICK[2]) & 0xFFFFFF;
        ticks += took;
        if (took > most) most = took;
    }
    if (status == 0) status = scene_outputs(&scene);

    for (int k = 0; k < SCENE_N_Y; k++) tell_number("y", scene.y[k]);
    tell("status", (uint64_t)status);
    tell("ticks", ticks);
    tell("most", most);
    tell("ram", sizeof scene);
}

static __attribute__((noinline)) void begin(void)
{
    memcpy(_data, _data_from, (size_t)((char *)_data_end - (char *)_data));
    memset(_bss, 0, (size_t)((char *)_bss_end - (char *)_bss));
    SYSTICK[1] = 0xFFFFFF;
    SYSTICK[2] = 0;
    SYSTICK[0] = 5; /* by the processor's clock */

    uint32_t *low = _bss_end, *here = (uint32_t *)__builtin_frame_address(0) - 64;
    for (uint32_t *at = low; at < here; at++) *at = PAINT;
    run();
    while (*low == PAINT) low++;
    tell("stack", (uint64_t)((char *)here - (char *)low));
    stop();
}

static void reset(void)
{
    CPACR |= 0xF << 20; /* the floating point unit */
    __asm__ volatile("dsb\n\tisb" ::: "memory");
    begin();
}

static void fault(void)
{
    tell("fault", 1);
    stop();
}

__attribute__((section(".vectors"), used)) static const uintptr_t vectors[16] = {
    (uintptr_t)_stack,
    (uintptr_t)reset,
    (uintptr_t)fault,
    (uintptr_t)fault,
};
