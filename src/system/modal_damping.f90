!> Damping of the vibrations of a body by the ratios of its modes as the scene holds it: with the joints and drivers, the inertia of
!> all other bodies, whose deflections are held, and without springs. Found once, as a matrix on the coordinates of the body, so
!> that it is the same for any coordinates that can have these modes. Floor: system. Source: doc/theory, eqs. (99), (R12), (R13).
module limber_system_modal_damping
   use limber_base_kinds, only: wp
   use limber_base_finite, only: dsyev
   use limber_model_scene, only: model_type
   use limber_system_eta_mass, only: update_eta_masses
   use limber_system_freedom, only: freedom_type, find_freedom
   use limber_system_kinematics, only: place_frames
   use limber_system_multiplier, only: update_jacobians, update_beam_masses, update_masses
   use limber_system_system, only: system_type, workspace_type
   implicit none
   private
   public :: any_modal, find_damping

   !> Most rates of frames of a scene whose motions are found
   integer, parameter :: most = 400
   !> Part of the largest stiffness, or inertia, that is none
   real(wp), parameter :: nothing = 1.0e-13_wp

contains

   !> Whether a body is damped by the ratios of its modes.
   pure logical function any_modal(model)
      type(model_type), intent(in) :: model
      integer :: i
      any_modal = .false.
      do i = 1, size(model%bodies)
         any_modal = any_modal .or. allocated(model%bodies(i)%ratio)
      end do
   end function any_modal

   !> Finds the damping of all such bodies.
   subroutine find_damping(system, work, model, q, missed)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(inout) :: work
      !> Of the system; the damping of its bodies is changed
      type(model_type), intent(inout) :: model
      !> Coordinates (nq)
      real(wp), intent(in) :: q(:)
      !> Bodies whose damping is that of their own coordinates: the scene is too large (bodies)
      logical, allocatable, intent(out) :: missed(:)
      integer :: i
      allocate (missed(size(model%bodies)))
      missed = .false.
      call place_frames(system%model, system%layout, system%model%dynamics%start, q, work%kinematics)
      call update_jacobians(system, work)
      call update_masses(system, work, q)
      call update_beam_masses(work)
      if (system%exact) call update_eta_masses(work)
      do i = 1, size(model%bodies)
         if (.not. allocated(model%bodies(i)%ratio)) cycle
         missed(i) = sum(system%layout%rates) > most
         if (.not. missed(i)) call damp_body(system, work, i, model%bodies(i)%ratio, model%bodies(i)%rayleigh, &
            & model%bodies(i)%reduced%damping)
      end do
   end subroutine find_damping

   !> The damping of one body, eq. (R13).
   subroutine damp_body(system, work, body, ratio, rayleigh, damping)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      integer, intent(in) :: body
      !> Of its modes in ascending order (n); factors of mass and stiffness
      real(wp), intent(in) :: ratio(:), rayleigh(2)
      !> (n, n)
      real(wp), intent(inout) :: damping(:, :)
      type(freedom_type) :: freedom
      real(wp), allocatable :: inverse(:), strained(:, :)
      real(wp) :: factor
      integer :: n, k, j, mode, count
      n = size(ratio)
      call find_freedom(system, work, .true., freedom, body)
      call find_modes(system, work, body, freedom%basis, strained, inverse)
      damping = 0.0_wp
      associate (reduced => system%model%bodies(body)%reduced)
         do k = 1, n
            damping(k, k) = rayleigh(2)*reduced%omega2(k)
         end do
         count = size(inverse)
         do j = 1, count
            ! In ascending order of frequencies
            mode = count + 1 - j
            factor = 2*ratio(mode)*sqrt(inverse(j)) + rayleigh(1)*inverse(j)
            do k = 1, n
               damping(:, k) = damping(:, k) + factor*strained(:, j)*strained(k, j)
            end do
         end do
      end associate
   end subroutine damp_body

   !> Modes of the motions that are left, eq. (R12): K psi on the coordinates of the body with psi.K psi = 1 (n, modes), and the
   !> inverses of the squared frequencies, ascending (modes).
   subroutine find_modes(system, work, body, basis, strained, inverse)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      integer, intent(in) :: body
      !> (nw, motions)
      real(wp), intent(in) :: basis(:, :)
      real(wp), allocatable, intent(out) :: strained(:, :), inverse(:)
      real(wp), allocatable :: stiffness(:, :), mass(:, :), value(:), room(:), free(:, :), weight(:)
      integer :: first, n, f, r, j, info
      f = size(basis, 2)
      n = system%layout%n(body)
      first = system%layout%w(body) + system%layout%rates(body)
      allocate (stiffness(f, f), mass(f, f), value(f), room(64*f + 64), weight(n))
      weight = system%model%bodies(body)%reduced%omega2
      do j = 1, f
         stiffness(:, j) = matmul(weight*basis(first:first + n - 1, j), basis(first:first + n - 1, :))
      end do
      call dsyev('V', 'L', f, stiffness, f, value, room, size(room), info)
      r = 0
      if (f > 0 .and. info == 0) r = count(value > nothing*maxval(value))
      call project_mass(system, work, matmul(basis, stiffness), mass)
      allocate (strained(n, r), inverse(r), free(f - r, f - r))
      if (r == 0) return
      strained = matmul(basis(first:first + n - 1, :), stiffness(:, f - r + 1:))
      do j = 1, r
         strained(:, j) = weight*strained(:, j)/sqrt(value(f - r + j))
         mass(:, f - r + j) = mass(:, f - r + j)/sqrt(value(f - r + j))
         mass(f - r + j, :) = mass(f - r + j, :)/sqrt(value(f - r + j))
      end do
      call condense(mass, f - r, room)
      free = 0.0_wp
      deallocate (stiffness)
      allocate (stiffness(r, r))
      stiffness = mass(f - r + 1:, f - r + 1:)
      call dsyev('V', 'L', r, stiffness, r, inverse, room, size(room), info)
      inverse = max(inverse, 0.0_wp)
      strained = matmul(strained, stiffness)
   end subroutine find_modes

   !> Inertia of motions: of the body with its coordinates, of all others as they are.
   subroutine project_mass(system, work, motion, mass)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> (nw, motions), (motions, motions)
      real(wp), intent(in) :: motion(:, :)
      real(wp), intent(out) :: mass(:, :)
      real(wp), allocatable :: product(:)
      integer :: i, j, m, n, at
      allocate (product(size(motion, 1)))
      do j = 1, size(motion, 2)
         product = 0.0_wp
         do i = 1, size(system%layout%w)
            at = system%layout%w(i)
            m = system%layout%rates(i)
            n = system%layout%n(i)
            product(at:at + m - 1) = matmul(work%bodies(i)%mass(:m, :m), motion(at:at + m - 1, j))
            if (n == 0) cycle
            associate (eta => motion(at + m:at + m + n - 1, j), coupling => work%bodies(i)%coupling)
               product(at:at + m - 1) = product(at:at + m - 1) + matmul(eta, coupling)
               product(at + m:at + m + n - 1) = eta + matmul(coupling, motion(at:at + m - 1, j))
               if (allocated(work%bodies(i)%eta_mass)) product(at + m:at + m + n - 1) = product(at + m:at + m + n - 1) &
                  & + matmul(work%bodies(i)%eta_mass, eta) - eta
            end associate
         end do
         mass(:, j) = matmul(product, motion)
      end do
   end subroutine project_mass

   !> Lets the first motions, which strain nothing, follow the others: M_yy - M_yx M_xx^-1 M_xy in the place of M_yy.
   subroutine condense(mass, free, room)
      real(wp), intent(inout) :: mass(:, :), room(:)
      integer, intent(in) :: free
      real(wp) :: block(free, free), value(free), part(size(mass, 1) - free)
      integer :: j, k, info
      if (free == 0) return
      block = mass(:free, :free)
      call dsyev('V', 'L', free, block, free, value, room, size(room), info)
      if (info /= 0) return
      do j = 1, free
         if (.not. value(j) > nothing*value(free)) cycle
         part = matmul(mass(free + 1:, :free), block(:, j))
         do k = 1, size(part)
            mass(free + 1:, free + k) = mass(free + 1:, free + k) - part*part(k)/value(j)
         end do
      end do
   end subroutine condense

end module limber_system_modal_damping
