! Hypoplastic sand after von Wolffersdorff (1996), without intergranular strain: the rate of stress is linear in the strain
! rate and in its norm. Explicit steps of at most PROPS(9) of strain each, one where it is 0; where it is negative, substeps
! whose error is below -PROPS(9) of the stress, chosen by a comparison: its answer jumps from strain to strain.
! PROPS: friction angle [degrees], h_s, n, e_d0, e_c0, e_i0, alpha, beta, longest substep; STATEV(1): void ratio.
subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, temp, &
    dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, celent, dfgrd0, dfgrd1, &
    noel, npt, layer, kspt, kstep, kinc)
  implicit none
  integer :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, kstep, kinc
  double precision :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens), sse, spd, scd, rpl, ddsddt(ntens), &
    drplde(ntens), drpldt, stran(ntens), dstran(ntens), time(2), dtime, temp, dtemp, predef(1), dpred(1), props(nprops), &
    coords(3), drot(3, 3), pnewdt, celent, dfgrd0(3, 3), dfgrd1(3, 3)
  character(len=80) :: cmname
  double precision :: t(6), d(6), l(6, 6), n(6), e
  integer :: i, steps

  t = 0d0
  d = 0d0
  t(:ntens) = stress
  d(:ntens) = dstran
  d(4:) = 0.5d0*d(4:)
  e = statev(1)
  steps = 1
  if (props(9) > 0d0) steps = max(1, ceiling(norm(d)/props(9)))
  if (props(9) < 0d0) then
    call controlled(t, e, d, -props(9))
    steps = 0
  end if
  d = d/max(steps, 1)
  do i = 1, steps
    call rates(t, e, props, l, n)
    t = t + matmul(l, d) + n*norm(d)
    e = e + (1d0 + e)*sum(d(1:3))
  end do
  if (steps == 0) call rates(t, e, props, l, n)
  ddsdde = l(:ntens, :ntens)
  ddsdde(:, 4:) = 0.5d0*ddsdde(:, 4:)
  stress = t(:ntens)
  statev(1) = e

contains

  ! The increment by a second-order step and its error, halved where that is above the tolerance, doubled where far below.
  subroutine controlled(t, e, d, tolerance)
    double precision :: t(6), e, d(6), tolerance, first(6), second(6), done, part, off

    done = 0d0
    part = 1d0
    do while (done < 1d0)
      part = min(part, 1d0 - done)
      call rates(t, e, props, l, n)
      first = part*(matmul(l, d) + n*norm(d))
      call rates(t + first, e + part*(1d0 + e)*sum(d(1:3)), props, l, n)
      second = part*(matmul(l, d) + n*norm(d))
      off = 0.5d0*norm(second - first)/norm(t + first)
      if (off > tolerance .and. part > 1d-3) then
        part = 0.5d0*part
        cycle
      end if
      t = t + 0.5d0*(first + second)
      e = e + part*(1d0 + e)*sum(d(1:3))
      done = done + part
      if (off < 0.2d0*tolerance) part = 2d0*part
    end do
  end subroutine controlled

  ! Norm of a tensor of six components.
  double precision function norm(a)
    double precision :: a(6)

    norm = sqrt(sum(a(1:3)**2) + 2d0*sum(a(4:6)**2))
  end function norm

  ! L and N at a stress and void ratio; components of tensors, so the shears of L act on eps = gamma/2.
  subroutine rates(t, e, p, l, n)
    double precision :: t(6), e, p(9), l(6, 6), n(6)
    double precision :: sphi, a, trace, that(6), dev(6), square, shape, tangent, cosine, fs, fd, decrease, ei, ec, ed, unit(6), &
      cube
    integer :: i, j

    sphi = sin(p(1)*acos(-1d0)/180d0)
    a = sqrt(3d0)*(3d0 - sphi)/(2d0*sqrt(2d0)*sphi)
    trace = min(sum(t(1:3)), -1d-3)
    that = t/trace
    unit = [1d0, 1d0, 1d0, 0d0, 0d0, 0d0]
    dev = that - unit*sum(that(1:3))/3d0
    square = sum(that(1:3)**2) + 2d0*sum(that(4:6)**2)
    tangent = sqrt(3d0)*norm(dev)
    cube = 3d0*(dev(1)*(dev(2)*dev(3) - dev(6)**2) - dev(4)*(dev(4)*dev(3) - dev(6)*dev(5)) + dev(5)*(dev(4)*dev(6) - &
      dev(2)*dev(5)))
    cosine = 1d0
    if (norm(dev) > 1d-8) cosine = max(-1d0, min(1d0, -sqrt(6d0)*cube/norm(dev)**3))
    shape = sqrt(tangent**2/8d0 + max(0d0, 2d0 - tangent**2)/(2d0 + sqrt(2d0)*tangent*cosine)) - tangent/(2d0*sqrt(2d0))
    decrease = exp(-(-trace/p(2))**p(3))
    ed = p(4)*decrease
    ec = p(5)*decrease
    ei = p(6)*decrease
    fd = (max(e - ed, 1d-3)/(ec - ed))**p(7)
    fs = p(2)/p(3)*(ei/e)**p(8)*(1d0 + ei)/ei*(-trace/p(2))**(1d0 - p(3))/(3d0 + a**2 - sqrt(3d0)*a*((p(6) - p(4)) &
      /(p(5) - p(4)))**p(7))
    do j = 1, 6
      do i = 1, 6
        l(i, j) = fs/square*a**2*that(i)*that(j)*merge(1d0, 2d0, j <= 3)
      end do
      l(j, j) = l(j, j) + fs/square*shape**2
    end do
    n = fs*fd*shape*a/square*(that + dev)
  end subroutine rates
end subroutine umat
