!> Small vibrations about a state. The lowest eigenvalues s and shapes of (s^2 M + s D + K) phi = 0 on the motions that the
!> constraints leave. Dense: `eigenmodes`. Floor: multibody. Source: doc/theory, eqs. (6.8), (6.10), (6.13), (6.14), (6.18);
!> Meirovitch 1967, chapter 9.
module limber_multibody_small_vibrations
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_text, only: as_text
   use limber_multibody_dense_eigenmodes, only: symmetric_modes, quadratic_modes, least_stiff, nothing
   use limber_multibody_free_motions, only: free_motions_type, rate_scales
   use limber_multibody_sparse_eigenmodes, only: nearest_eigenvalues, by_mass
   use limber_multibody_system, only: system_type
   use limber_multibody_tangent, only: tangent_type
   use limber_multibody_tangent_products, only: times_mass, times_damping, times_stiffness
   implicit none
   private
   public :: vibrations_type, find_vibrations, find_large_vibrations, find_growth, kind_of_growth, add_rotation_damping

   !> Velocity terms that count: none, those that do no work (gyroscopic ones), all
   integer, parameter, public :: no_damping = 0, gyroscopic = 1, all_damping = 2

   !> Modes in ascending |s|, of a conjugate pair that with positive frequency
   type :: vibrations_type
      !> Circular frequency Im s and growth Re s (modes) [rad/time], [1/time]
      real(wp), allocatable :: frequency(:), growth(:)
      !> Shapes in the layout of the rates (nw, modes), phi^H M phi = 1, the largest entry real and positive
      complex(wp), allocatable :: shape(:, :)
   end type vibrations_type

contains

   !> The lowest modes.
   subroutine find_vibrations(system, tangent, freedom, damping, wanted, vibrations, error)
      type(system_type), intent(in) :: system
      !> Mass, damping and stiffness at the state
      type(tangent_type), intent(in) :: tangent
      type(free_motions_type), intent(in) :: freedom
      !> Which velocity terms count
      integer, intent(in) :: damping
      !> Most modes
      integer, intent(in) :: wanted
      type(vibrations_type), intent(out) :: vibrations
      !> The eigenvalues could not be found
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: mass(:, :), damper(:, :), stiffness(:, :)
      complex(wp), allocatable :: value(:), vector(:, :)
      logical :: is_symmetric
      integer :: n, j
      n = size(freedom%basis, 2)
      call free_matrices(system, tangent, freedom, mass, damper, stiffness)
      if (damping == no_damping) damper = 0.0_wp
      if (damping == gyroscopic) damper = 0.5_wp*(damper - transpose(damper))
      is_symmetric = n == 0
      if (n > 0) is_symmetric = maxval(abs(stiffness - transpose(stiffness))) <= 1.0e-10_wp*maxval(abs(stiffness)) &
         & .and. maxval(abs(damper)) <= 0.0_wp
      if (is_symmetric) call symmetric_modes(mass, stiffness, wanted, value, vector)
      if (.not. allocated(value)) call quadratic_modes(mass, damper, stiffness, wanted, value, vector)
      if (.not. allocated(value)) then
         call raise(error, 'the eigenvalues of the '//as_text(n)//' free motions are not found (LAPACK)')
         return
      end if
      allocate (vibrations%frequency(size(value)), vibrations%growth(size(value)), vibrations%shape(system%layout%nw, size(value)))
      vibrations%frequency = aimag(value)
      vibrations%growth = real(value, wp)
      do j = 1, size(value)
         call normalise(mass, vector(:, j))
         vibrations%shape(:, j) = cmplx(matmul(freedom%basis, real(vector(:, j), wp)), &
            & matmul(freedom%basis, aimag(vector(:, j))), wp)
         call turn_phase(rate_scales(system), vibrations%shape(:, j))
      end do
   end subroutine find_vibrations

   !> Mass, damping and stiffness on the motions that are left, eq. (6.2), each (number, number).
   subroutine free_matrices(system, tangent, freedom, mass, damper, stiffness)
      type(system_type), intent(in) :: system
      type(tangent_type), intent(in) :: tangent
      type(free_motions_type), intent(in) :: freedom
      real(wp), allocatable, intent(out) :: mass(:, :), damper(:, :), stiffness(:, :)
      real(wp) :: product(system%layout%nw)
      integer :: n, j
      n = size(freedom%basis, 2)
      allocate (mass(n, n), damper(n, n), stiffness(n, n))
      do j = 1, n
         product = 0.0_wp
         call times_mass(system, tangent, 1.0_wp, freedom%basis(:, j), product)
         mass(:, j) = matmul(product, freedom%basis)
         product = 0.0_wp
         call times_damping(system, tangent, 1.0_wp, freedom%basis(:, j), product)
         damper(:, j) = matmul(product, freedom%basis)
         product = 0.0_wp
         call times_stiffness(system, tangent, 1.0_wp, freedom%basis(:, j), product)
         stiffness(:, j) = matmul(product, freedom%basis)
      end do
   end subroutine free_matrices

   !> Whether small motions about a state grow, with all velocity terms, and which grows the fastest.
   subroutine find_growth(system, tangent, freedom, fastest, growth, frequency, motion, done)
      type(system_type), intent(in) :: system
      type(tangent_type), intent(in) :: tangent
      type(free_motions_type), intent(in) :: freedom
      !> Frequency above which vibrations do not count [rad/time]
      real(wp), intent(in) :: fastest
      !> Largest Re s, with its |Im s| [1/time], both zero if none grows; a frequency of zero is divergence, any other is flutter
      real(wp), intent(out) :: growth, frequency
      !> Its real part in the layout of the rates (nw), scaled to unit length; unchanged if none grows
      real(wp), intent(inout) :: motion(:)
      !> False if the eigenvalues are not found
      logical, intent(out) :: done
      real(wp), allocatable :: mass(:, :), damper(:, :), stiffness(:, :)
      complex(wp), allocatable :: value(:), vector(:, :)
      integer :: j, found
      growth = 0.0_wp
      frequency = 0.0_wp
      call free_matrices(system, tangent, freedom, mass, damper, stiffness)
      call quadratic_modes(mass, damper, stiffness, 2*size(mass, 1), value, vector)
      done = allocated(value)
      if (.not. done) return
      found = 0
      do j = 1, size(value)
         if (kind_of_growth(aimag(value(j)), real(value(j), wp), maxval(abs(damper)) > 0.0_wp) == '') cycle
         if (real(value(j), wp) <= growth .or. aimag(value(j)) > fastest) cycle
         growth = real(value(j), wp)
         found = j
      end do
      if (found == 0) return
      frequency = aimag(value(found))
      if (kind_of_growth(frequency, growth, .true.) == 'divergence') frequency = 0.0_wp
      motion = matmul(freedom%basis, real(vector(:, found), wp))
      motion = motion/norm2(motion/rate_scales(system))
   end subroutine find_growth

   !> What becomes of a mode: 'flutter' if its vibrations grow, 'divergence' if it grows without vibrating, '' if it does not grow.
   pure function kind_of_growth(frequency, growth, is_damped) result(kind)
      real(wp), intent(in) :: frequency, growth
      !> Without damping two frequencies meet where flutter begins, and round-off is magnified
      logical, intent(in) :: is_damped
      character(:), allocatable :: kind
      !> Growth beside |s| that is round-off: without damping and with
      real(wp), parameter :: none(2) = [1.0e-6_wp, 1.0e-10_wp], no_vibration = 1.0e-6_wp
      kind = ''
      if (.not. growth > merge(none(2), none(1), is_damped)*hypot(frequency, growth)) return
      kind = 'flutter'
      if (abs(frequency) <= no_vibration*growth) kind = 'divergence'
   end function kind_of_growth

   !> The lowest undamped modes of a large scene with a symmetric stiffness, by ARPACK, eq. (6.14).
   subroutine find_large_vibrations(system, tangent, wanted, vibrations, error)
      type(system_type), intent(in) :: system
      !> Its matrix is factored anew
      type(tangent_type), intent(inout) :: tangent
      integer, intent(in) :: wanted
      type(vibrations_type), intent(out) :: vibrations
      !> No convergence
      type(error_type), allocatable, intent(out) :: error
      !> Largest |omega^2| beside the least up to which zero is a shift that loses nothing
      real(wp), parameter :: widest = 1.0e9_wp
      real(wp), allocatable :: value(:), motion(:, :)
      real(wp) :: shift
      logical :: done
      integer :: count, j
      count = min(wanted, system%layout%nw - system%nc - 1)
      allocate (value(count), motion(system%layout%nw, count))
      shift = 0.0_wp
      call nearest_eigenvalues(system, tangent, by_mass, shift, count, value, motion, done)
      if (done) done = maxval(abs(value)) <= widest*minval(abs(value))
      if (.not. done) then
         ! Something moves freely: a shift below zero, then one that is no larger than what is elastic
         shift = -1.0e-8_wp*maxval(abs(tangent%parts(:, 3)))/maxval(abs(tangent%parts(:, 1)))
         shift = min(shift, -tiny(shift))
         call nearest_eigenvalues(system, tangent, by_mass, shift, count, value, motion, done)
         if (done .and. any(value > 0.0_wp)) then
            shift = -least_stiff(value)
            call nearest_eigenvalues(system, tangent, by_mass, shift, count, value, motion, done)
         end if
      end if
      if (done) call add_missing(system, tangent, shift, value, motion, done)
      if (.not. done) then
         call raise(error, 'the eigenvalues of the scene are not found (ARPACK)')
         return
      end if
      where (abs(value) <= nothing*abs(shift)) value = 0.0_wp
      allocate (vibrations%frequency(count), vibrations%growth(count), vibrations%shape(system%layout%nw, count))
      vibrations%frequency = sqrt(max(value, 0.0_wp))
      vibrations%growth = sqrt(max(-value, 0.0_wp))
      do j = 1, count
         vibrations%shape(:, j) = cmplx(motion(:, j), 0.0_wp, wp)
         call turn_phase(rate_scales(system), vibrations%shape(:, j))
      end do
   end subroutine find_large_vibrations

   !> Looks for eigenvalues that ARPACK has passed over, as of equal frequencies: the nearest one beside all that are found must be
   !> farther from the shift than these are. Takes those in that are nearer, and gives all motions unit modal mass.
   subroutine add_missing(system, tangent, shift, value, motion, done)
      type(system_type), intent(in) :: system
      type(tangent_type), intent(inout) :: tangent
      real(wp), intent(in) :: shift
      !> In ascending distance from the shift (modes); (nw, modes)
      real(wp), intent(inout) :: value(:), motion(:, :)
      logical, intent(out) :: done
      !> Difference of eigenvalues that is round-off
      real(wp), parameter :: same = 1.0e-9_wp
      real(wp) :: product(size(motion, 1)), next(1), other(size(motion, 1), 1)
      integer :: last, j, round
      last = size(value)
      do round = 0, last
         do j = 1, last
            product = 0.0_wp
            call times_mass(system, tangent, 1.0_wp, motion(:, j), product)
            motion(:, j) = motion(:, j)/sqrt(max(dot_product(product, motion(:, j)), tiny(1.0_wp)))
         end do
         call nearest_eigenvalues(system, tangent, by_mass, shift, 1, next, other, done, motion)
         if (.not. done) return
         if (abs(next(1) - shift) >= (1 - same)*abs(value(last) - shift)) return
         j = count(abs(value - shift) <= abs(next(1) - shift)) + 1
         value(j + 1:) = value(j:last - 1)
         motion(:, j + 1:) = motion(:, j:last - 1)
         value(j) = next(1)
         motion(:, j) = other(:, 1)
      end do
      done = .false.
   end subroutine add_missing

   !> Adds what a steady rotation adds to the damping of a body, whose place is told in turning axes: 2 speed M J on r.
   pure subroutine add_rotation_damping(speed, mass, damping)
      real(wp), intent(in) :: speed, mass(:, :)
      real(wp), intent(inout) :: damping(:, :)
      damping(:, 1) = damping(:, 1) + 2*speed*mass(:, 2)
      damping(:, 2) = damping(:, 2) - 2*speed*mass(:, 1)
   end subroutine add_rotation_damping

   !> Unit modal mass, unless the shape has none.
   pure subroutine normalise(mass, vector)
      real(wp), intent(in) :: mass(:, :)
      complex(wp), intent(inout) :: vector(:)
      real(wp) :: modal
      integer :: j
      modal = 0.0_wp
      do j = 1, size(vector)
         modal = modal + real(conjg(vector(j))*sum(mass(:, j)*vector), wp)
      end do
      if (modal > 0.0_wp) vector = vector/sqrt(modal)
   end subroutine normalise

   !> Turns the phase so that the largest entry, each relative to its scale, is real and positive.
   pure subroutine turn_phase(scale, shape)
      real(wp), intent(in) :: scale(:)
      complex(wp), intent(inout) :: shape(:)
      integer :: i
      i = maxloc(abs(shape)/scale, 1)
      if (abs(shape(i)) > 0.0_wp) shape = shape*conjg(shape(i))/abs(shape(i))
   end subroutine turn_phase

end module limber_multibody_small_vibrations
