/* Processor features that are not accessible in Fortran. */

int qsmpm_has_avx2(void);
void qsmpm_fetch(const double *first, int count);

/* Returns 1 if the processor has AVX2 and FMA. */
int qsmpm_has_avx2(void)
{
#if defined(__x86_64__) && defined(__GNUC__)
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
    return 0;
#endif
}

/* Prefetches numbers that will be changed soon, one cache line at a time. */
void qsmpm_fetch(const double *first, int count)
{
    for (int c = 0; c < count + 7; c += 8) __builtin_prefetch(first + c, 1);
}
