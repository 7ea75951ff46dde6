!> Deflections at the start of a free motion. In equilibrium with the loads and the inertia of the motion that the frames then
!> begin, which is that of held deflections. Newton's method with all that a deflection changes: its own elastic force, springs and
!> other loads, the frames that close the joints, and with them the accelerations and multipliers. Floor: multibody. Source:
!> doc/theory, eqs. (4.44)-(4.46); Saad and Schultz 1986 (GMRES).
module limber_multibody_first_deflections
   use limber_base_kinds, only: wp
   use limber_base_finite, only: dgetrf, dgetrs
   use limber_model_model, only: ground
   use limber_multibody_driven_motion, only: driven_motion_type, factor_held, correct_motion, follows, held_position
   use limber_multibody_kinematics, only: move_frames
   use limber_multibody_layout, only: rates_of, velocities_of
   use limber_multibody_motion_residual, only: linearise_motion, motion_residual
   use limber_multibody_system, only: system_type, workspace_type
   use limber_multibody_tangent, only: solve_refined
   use limber_multibody_tangent_products, only: times_mass, times_stiffness
   implicit none
   private
   public :: balance_start, start_motion

   !> Most directions of GMRES; springs and joints are few beside the bodies' own stiffness, by which it is preconditioned
   integer, parameter :: most_directions = 80

   !> Factors of a body's own stiffness (n, n)
   type :: factors_type
      real(wp), allocatable :: matrix(:, :)
      integer, allocatable :: pivot(:)
   end type factors_type

contains

   !> Brings the deflections of a scene that moves freely into equilibrium with the loads and the inertia of its motion, whose
   !> accelerations are those of held deflections; joints are closed by the frames. Rates of deflection become zero.
   subroutine balance_start(system, work, held, t, q, v, done)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(driven_motion_type), intent(inout) :: held
      real(wp), intent(in) :: t
      !> Coordinates and velocities (nq)
      real(wp), intent(inout) :: q(:), v(:)
      !> False if that does not converge
      logical, intent(out) :: done
      integer, parameter :: most = 200
      real(wp), parameter :: small = 1.0e-13_wp, stalled = 1.0e-9_wp
      real(wp) :: size_of, last, change
      integer :: round
      logical :: singular
      done = .false.
      last = huge(last)
      do round = 1, most
         call start_motion(system, work, held, t, q, v, singular)
         if (singular) return
         if (.not. follows(held, v)) return
         call motion_residual(system, work, t, q, v, held%a, held%lambda, held%motion, held%rates)
         call linearise_motion(system, work, held%tangent, q, v, held%a, held%lambda)
         call relax_deflections(system, work, held, q, size_of)
         if (.not. size_of < huge(size_of)) return
         call held_position(system, work, held, t, q, change, done)
         if (.not. done) return
         done = size_of <= small .or. (size_of <= stalled .and. size_of >= 0.5_wp*last)
         if (done) return
         last = size_of
      end do
   end subroutine balance_start

   !> Velocities that the position asks for, and the accelerations and multipliers of the motion with held deflections.
   subroutine start_motion(system, work, held, t, q, v, singular)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(driven_motion_type), intent(inout) :: held
      real(wp), intent(in) :: t, q(:)
      real(wp), intent(inout) :: v(:)
      logical, intent(out) :: singular
      call rates_of(system%layout, q, v, held%w)
      held%w(held%deflections) = 0.0_wp
      call velocities_of(system%layout, q, held%w, v)
      call factor_held(system, work, held, t, q, v, singular)
      if (.not. singular) call correct_motion(system, work, held, t, q, v)
   end subroutine start_motion

   !> One Newton step of all deflections, eq. (4.46), by GMRES.
   subroutine relax_deflections(system, work, held, q, size_of)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> With the residual, derivatives at it, and factors with held deflections
      type(driven_motion_type), intent(inout) :: held
      real(wp), intent(inout) :: q(:)
      !> Largest change relative to its scale; huge if there is none
      real(wp), intent(out) :: size_of
      real(wp), parameter :: limit = 0.3_wp
      type(factors_type), allocatable :: factors(:)
      real(wp), allocatable :: step(:)
      integer :: i, n, first
      logical :: singular
      size_of = 0.0_wp
      if (size(held%deflections) == 0) return
      size_of = huge(1.0_wp)
      call factor_bodies(system, held, factors, singular)
      if (singular) return
      call drift_of_accelerations(system, work, held, q)
      allocate (step, source=-held%motion(held%deflections))
      call divide(system, factors, step)
      if (.not. all(abs(step) <= huge(1.0_wp))) return
      call krylov_step(system, held, factors, step)
      size_of = maxval(abs(step/held%scale(held%deflections)))
      if (.not. size_of < huge(1.0_wp)) return
      if (size_of > limit) step = step*limit/size_of
      first = 0
      do i = 1, size(system%layout%q)
         n = system%layout%n(i)
         associate (at => system%layout%q(i) + 4)
            q(at:at + n - 1) = q(at:at + n - 1) + step(first + 1:first + n)
         end associate
         first = first + n
      end do
   end subroutine relax_deflections

   !> Factors of the stiffness of each body's deflections.
   subroutine factor_bodies(system, held, factors, singular)
      type(system_type), intent(in) :: system
      type(driven_motion_type), intent(in) :: held
      type(factors_type), allocatable, intent(out) :: factors(:)
      logical, intent(out) :: singular
      integer :: i, n, m, info
      singular = .false.
      allocate (factors(size(system%layout%q)))
      do i = 1, size(factors)
         n = system%layout%n(i)
         m = system%layout%rates(i)
         allocate (factors(i)%matrix(n, n), factors(i)%pivot(n))
         if (n == 0) cycle
         factors(i)%matrix = held%tangent%bodies(i)%stiffness(m + 1:, m + 1:)
         call dgetrf(n, n, factors(i)%matrix, n, factors(i)%pivot, info)
         singular = singular .or. info /= 0
      end do
   end subroutine factor_bodies

   !> Divides forces on the deflections by the stiffness of their own bodies.
   subroutine divide(system, factors, force)
      type(system_type), intent(in) :: system
      type(factors_type), intent(in) :: factors(:)
      !> Forces, then deflections (deflections)
      real(wp), contiguous, intent(inout) :: force(:)
      integer :: i, n, first, info
      first = 1
      do i = 1, size(factors)
         n = system%layout%n(i)
         call dgetrs('N', n, 1, factors(i)%matrix, n, factors(i)%pivot, force(first:first + n - 1), n, info)
         first = first + n
      end do
   end subroutine divide

   !> What displacements change the accelerations of held deflections by that the constraints allow: derivatives of G a into the
   !> drift of the tangent. The kinematics are left moved by these accelerations.
   subroutine drift_of_accelerations(system, work, held, q)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      type(driven_motion_type), intent(inout) :: held
      real(wp), intent(in) :: q(:)
      integer :: i
      call velocities_of(system%layout, q, held%a, held%moved)
      call move_frames(system%model, system%layout, q, held%moved, work%kinematics)
      do i = 1, size(system%constraints)
         associate (c => held%tangent%constraints(i))
            c%first_drift = 0.0_wp
            c%second_drift = 0.0_wp
            call system%constraints(i)%item%drift(work%kinematics, c%first_drift, c%second_drift)
         end associate
      end do
   end subroutine drift_of_accelerations

   !> Solves eq. (4.46): GMRES without restarts, preconditioned by the bodies' own stiffness.
   subroutine krylov_step(system, held, factors, step)
      type(system_type), intent(in) :: system
      type(driven_motion_type), intent(inout) :: held
      type(factors_type), intent(in) :: factors(:)
      !> Right-hand side, then solution, both preconditioned (deflections)
      real(wp), intent(inout) :: step(:)
      real(wp), parameter :: exact = 1.0e-13_wp
      real(wp), allocatable :: basis(:, :), upper(:, :)
      real(wp) :: cosine(most_directions), sine(most_directions), right(most_directions + 1), first, length
      integer :: j, k, most, used
      most = min(size(step), most_directions)
      length = norm2(step)
      if (.not. length > 0.0_wp) return
      allocate (basis(size(step), most + 1), upper(most + 1, most))
      upper = 0.0_wp
      right = 0.0_wp
      right(1) = length
      basis(:, 1) = step/length
      used = most
      do k = 1, most
         call respond(system, held, factors, basis(:, k), basis(:, k + 1))
         do j = 1, k
            upper(j, k) = dot_product(basis(:, j), basis(:, k + 1))
            basis(:, k + 1) = basis(:, k + 1) - upper(j, k)*basis(:, j)
         end do
         upper(k + 1, k) = norm2(basis(:, k + 1))
         if (upper(k + 1, k) > 0.0_wp) basis(:, k + 1) = basis(:, k + 1)/upper(k + 1, k)
         do j = 1, k - 1
            first = upper(j, k)
            upper(j, k) = cosine(j)*first + sine(j)*upper(j + 1, k)
            upper(j + 1, k) = cosine(j)*upper(j + 1, k) - sine(j)*first
         end do
         first = hypot(upper(k, k), upper(k + 1, k))
         cosine(k) = upper(k, k)/first
         sine(k) = upper(k + 1, k)/first
         upper(k, k) = first
         right(k + 1) = -sine(k)*right(k)
         right(k) = cosine(k)*right(k)
         if (abs(right(k + 1)) > exact*length) cycle
         used = k
         exit
      end do
      do k = used, 1, -1
         right(k) = (right(k) - dot_product(upper(k, k + 1:used), right(k + 1:used)))/upper(k, k)
      end do
      step = matmul(basis(:, :used), right(:used))
   end subroutine krylov_step

   !> What a change of the deflections changes the forces on them by, eqs. (4.44)-(4.46), divided by the bodies' own stiffness.
   subroutine respond(system, held, factors, deflection, answer)
      type(system_type), intent(in) :: system
      type(driven_motion_type), intent(inout) :: held
      type(factors_type), intent(in) :: factors(:)
      !> (deflections)
      real(wp), intent(in) :: deflection(:)
      real(wp), contiguous, intent(out) :: answer(:)
      real(wp) :: change(system%layout%nw), force(system%layout%nw)
      associate (nw => system%layout%nw, solution => held%solution)
         change = 0.0_wp
         change(held%deflections) = deflection
         solution(:nw) = 0.0_wp
         solution(nw + 1:) = 0.0_wp
         call add_rows(system, held, change, .false., -1.0_wp, solution(nw + 1:))
         call solve_refined(held%tangent, nw, held%solution, held%correction)
         change = solution(:nw)
         change(held%deflections) = deflection
         force = 0.0_wp
         call times_stiffness(system, held%tangent, 1.0_wp, change, force)
         solution(:nw) = -force
         solution(held%deflections) = 0.0_wp
         solution(nw + 1:) = 0.0_wp
         call add_rows(system, held, change, .true., -1.0_wp, solution(nw + 1:))
         call solve_refined(held%tangent, nw, held%solution, held%correction)
         solution(held%deflections) = 0.0_wp
         call times_mass(system, held%tangent, 1.0_wp, solution(:nw), force)
         call add_reactions(system, held, solution(nw + 1:), force)
      end associate
      answer = force(held%deflections)
      call divide(system, factors, answer)
   end subroutine respond

   !> Adds the rows of all constraints, or their drift, times a vector.
   pure subroutine add_rows(system, held, vector, drift, factor, product)
      type(system_type), intent(in) :: system
      type(driven_motion_type), intent(in) :: held
      !> (nw)
      real(wp), intent(in) :: vector(:)
      logical, intent(in) :: drift
      real(wp), intent(in) :: factor
      !> (nc)
      real(wp), intent(inout) :: product(:)
      integer :: i
      do i = 1, size(system%constraints)
         associate (c => held%tangent%constraints(i), item => system%constraints(i)%item)
            associate (own => product(item%first:item%first + item%rows - 1))
               if (drift) then
                  call add(item%bodies(1), c%first_drift, own)
                  call add(item%bodies(2), c%second_drift, own)
               else
                  call add(item%bodies(1), c%first, own)
                  call add(item%bodies(2), c%second, own)
               end if
            end associate
         end associate
      end do

   contains

      pure subroutine add(body, rows, sum)
         integer, intent(in) :: body
         real(wp), intent(in) :: rows(:, :)
         real(wp), intent(inout) :: sum(:)
         if (body == ground) return
         sum = sum + factor*matmul(rows, vector(system%layout%w(body):system%layout%w(body) + size(rows, 2) - 1))
      end subroutine add

   end subroutine add_rows

   !> Adds what multipliers exert.
   subroutine add_reactions(system, held, lambda, force)
      type(system_type), intent(in) :: system
      type(driven_motion_type), intent(in) :: held
      !> (nc); (nw)
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(inout) :: force(:)
      integer :: i
      do i = 1, size(system%constraints)
         associate (c => held%tangent%constraints(i), item => system%constraints(i)%item)
            call add(item%bodies(1), c%first, lambda(item%first:item%first + item%rows - 1))
            call add(item%bodies(2), c%second, lambda(item%first:item%first + item%rows - 1))
         end associate
      end do

   contains

      subroutine add(body, rows, multipliers)
         integer, intent(in) :: body
         real(wp), intent(in) :: rows(:, :), multipliers(:)
         integer :: at
         if (body == ground) return
         at = system%layout%w(body)
         force(at:at + size(rows, 2) - 1) = force(at:at + size(rows, 2) - 1) + matmul(multipliers, rows)
      end subroutine add

   end subroutine add_reactions

end module limber_multibody_first_deflections
