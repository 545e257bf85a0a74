/* Starts a Cortex-M4F: a vector table, and a reset handler that enables the FPU before newlib
 * starts. */
#include <stdint.h>

extern uint32_t stack_top[];
void _start(void);

static void reset(void) {
    volatile uint32_t *cpacr = (volatile uint32_t *)0xe000ed88;
    *cpacr |= UINT32_C(0xf) << 20;
    __asm__ volatile("dsb\n\tisb");
    _start();
}

/* Reports a failure to the debugger, here QEMU: SYS_EXIT with an internal error. */
static void fault(void) {
    register uint32_t operation __asm__("r0") = 0x18;
    register uint32_t reason __asm__("r1") = 0x20024;
    __asm__ volatile("bkpt 0xab" : : "r"(operation), "r"(reason) : "memory");
    for (;;) {
    }
}

struct vectors {
    const uint32_t *stack_top;
    void (*handlers[15])(void);
};

__attribute__((section(".vectors"), used)) static const struct vectors vectors = {
    stack_top,
    {reset, fault, fault, fault, fault, fault},
};
