!> Small vibrations of an exact beam with its ends held. Frequency, deflection, bending moment and shear force of each, and by how
!> much the functions take the frequency too high. Floor: beam. Source: doc/theory, part 2, eqs. (7.56), (7.57).
module limber_beam_exact_vibrations
   use limber_base_kinds, only: wp
   use limber_base_finite, only: dsygv
   use limber_beam_exact_beam, only: exact_type, reach_of, angles_at, sum_along
   use limber_beam_exact_profile, only: of_ei
   use limber_beam_beam_mesh, only: support_type
   implicit none
   private
   public :: exact_vibrations_type, new_held

   !> Motions of the beam as a whole: across itself, and its rotation
   integer, parameter :: whole = 2
   !> Part of the largest squared frequency below which a motion is none of bending; what counts as nothing in a condition
   real(wp), parameter :: still = 1.0e-9_wp, nothing = 1.0e-9_wp

   !> Vibrations of unit modal mass, in ascending order
   type :: exact_vibrations_type
      integer :: count = 0
      !> Squared frequency, and how much its root is too high, relative (vibrations)
      real(wp), allocatable :: omega2(:), error(:)
      !> Amplitude of each vibration in unit coordinates (vibrations, angles)
      real(wp), allocatable :: part(:, :)
      !> Deflection of the axis, bending moment and shear force by equilibrium of a unit amplitude (stations, vibrations)
      real(wp), allocatable :: place(:, :), moment(:, :), shear(:, :)
   end type exact_vibrations_type

contains

   !> Finds them; none if the functions allow none.
   subroutine new_held(exact, support, held)
      type(exact_type), intent(in) :: exact
      type(support_type), intent(in) :: support
      type(exact_vibrations_type), intent(out) :: held
      real(wp) :: moved(exact%points, exact%angles + whole), mass(exact%angles + whole, exact%angles + whole)
      real(wp), allocatable :: motions(:, :), heavy(:, :), stiff(:, :), value(:), room(:)
      integer :: free, info, i, j, rigid
      moved = motions_of(exact)
      mass = masses_of(exact, moved)
      call held_motions(exact, support, motions)
      free = size(motions, 2)
      allocate (held%omega2(0), held%error(0), held%part(0, 0), held%place(0, 0), held%moment(0, 0), held%shear(0, 0))
      if (free == 0) return
      allocate (heavy(free, free), stiff(free, free), value(free), room(64*free + 64))
      heavy = matmul(transpose(motions), matmul(mass, motions))
      do j = 1, free
         do i = 1, free
            ! The curvatures of the functions are orthonormal in the stiffness up to the squared frequencies
            stiff(i, j) = sum(motions(whole + 1:, i)*stiffness_of(exact)*motions(whole + 1:, j))
         end do
      end do
      call dsygv(1, 'V', 'L', free, stiff, free, heavy, free, value, room, size(room), info)
      if (info /= 0) return
      rigid = count(value <= still*maxval(value))
      held%count = free - rigid
      held%omega2 = value(rigid + 1:)
      motions = matmul(motions, stiff(:, rigid + 1:))
      ! By the stiffness: what a support that moves bends as at rest is no vibration
      deallocate (held%part)
      allocate (held%part(held%count, exact%angles))
      do j = 1, held%count
         held%part(j, :) = stiffness_of(exact)*motions(whole + 1:, j)/held%omega2(j)
      end do
      held%place = matmul(moved(:exact%stations, :), motions)
      call find_forces(exact, support, moved, motions, held)
   end subroutine new_held

   !> Squared frequencies of the functions with the frame held (angles).
   pure function stiffness_of(exact) result(value)
      type(exact_type), intent(in) :: exact
      real(wp) :: value(exact%angles)
      integer :: k
      do k = 1, exact%angles
         value(k) = sum(exact%weight*exact%section(of_ei, :)*exact%kappa(k, :)**2)
      end do
   end function stiffness_of

   !> Displacements across the axis of the points, of the beam as a whole and of each function (points, 2 + angles).
   pure function motions_of(exact) result(moved)
      type(exact_type), intent(in) :: exact
      real(wp) :: moved(exact%points, exact%angles + whole)
      integer :: i, k, n
      n = exact%stations
      moved(:, 1) = 1.0_wp
      moved(:n, 2) = exact%s - exact%origin
      moved(n + 1:, 2) = exact%lump_at - exact%origin
      do i = 1, exact%angles
         moved(:n, whole + i) = sum_along(exact, exact%psi(i, :)) - sum(exact%base*exact%psi(i, :))
         do k = 1, exact%points - n
            moved(n + k, whole + i) = sum(exact%reach(:, k)*exact%psi(i, :))
         end do
      end do
   end function motions_of

   !> The mass matrix of these motions.
   pure function masses_of(exact, moved) result(mass)
      type(exact_type), intent(in) :: exact
      real(wp), intent(in) :: moved(:, :)
      real(wp) :: mass(size(moved, 2), size(moved, 2))
      integer :: i, j
      do j = 1, size(moved, 2)
         do i = 1, size(moved, 2)
            mass(i, j) = sum(exact%mass*moved(:, i)*moved(:, j))
         end do
      end do
      mass(whole + 1:, whole + 1:) = mass(whole + 1:, whole + 1:) + exact%rotary_mass
      mass(2, whole + 1:) = mass(2, whole + 1:) + exact%rotary
      mass(whole + 1:, 2) = mass(whole + 1:, 2) + exact%rotary
      mass(2, 2) = mass(2, 2) + sum(exact%inertia)
   end function masses_of

   !> Motions that the support allows: those of the beam as a whole give way first (2 + angles, motions).
   pure subroutine held_motions(exact, support, motions)
      type(exact_type), intent(in) :: exact
      type(support_type), intent(in) :: support
      real(wp), allocatable, intent(out) :: motions(:, :)
      integer :: i
      allocate (motions(exact%angles + whole, exact%angles + whole))
      motions = 0.0_wp
      do i = 1, size(motions, 1)
         motions(i, i) = 1.0_wp
      end do
      if (support%w_start) call hold(deflections_at(0.0_wp), motions)
      if (support%w_end) call hold(deflections_at(exact%total), motions)
      if (support%theta_start) call hold([0.0_wp, 1.0_wp, angles_at(exact, 0.0_wp)], motions)
      if (support%theta_end) call hold([0.0_wp, 1.0_wp, angles_at(exact, exact%total)], motions)

   contains

      !> Deflection that each motion makes at a place.
      pure function deflections_at(place) result(row)
         real(wp), intent(in) :: place
         real(wp) :: row(exact%angles + whole), reach(exact%stations)
         reach = reach_of(exact, place) - exact%base
         row(:whole) = [1.0_wp, place - exact%origin]
         row(whole + 1:) = matmul(exact%psi, reach)
      end function deflections_at

   end subroutine held_motions

   !> Takes out what a condition forbids.
   pure subroutine hold(row, motions)
      !> The condition (2 + angles)
      real(wp), intent(in) :: row(:)
      real(wp), allocatable, intent(inout) :: motions(:, :)
      real(wp) :: felt(size(motions, 2)), most
      integer :: j, out
      felt = matmul(row, motions)
      most = 0.0_wp
      if (size(felt) > 0) most = maxval(abs(felt))
      if (.not. most > nothing) return
      out = maxloc(abs(felt), dim=1)
      do j = 1, size(felt)
         if (.not. abs(felt(j)) > nothing*most .or. any(abs(motions(whole + 1:, j)) > 0.0_wp)) cycle
         out = j
         exit
      end do
      do j = 1, size(felt)
         if (j /= out) motions(:, j) = motions(:, j) - felt(j)/felt(out)*motions(:, out)
      end do
      motions = motions(:, [(j, j=1, out - 1), (j, j=out + 1, size(felt))])
   end subroutine hold

   !> Bending moments and shear forces by equilibrium, with the forces of the supports that make the least difference from what the
   !> functions have, and the error of the frequency which is left, eq. (7.57).
   pure subroutine find_forces(exact, support, moved, motions, held)
      type(exact_type), intent(in) :: exact
      type(support_type), intent(in) :: support
      !> (points, 2 + angles), (2 + angles, vibrations)
      real(wp), intent(in) :: moved(:, :), motions(:, :)
      type(exact_vibrations_type), intent(inout) :: held
      real(wp) :: behind(exact%stations), lack(exact%stations), unit(exact%stations, 2), pushed(exact%points), saved
      real(wp) :: share(exact%stations, exact%stations), turned(exact%stations)
      integer :: i, j, k
      deallocate (held%error, held%moment, held%shear)
      allocate (held%error(held%count))
      allocate (held%moment(exact%stations, held%count), held%shear(exact%stations, held%count))
      held%moment = 0.0_wp
      held%shear = 0.0_wp
      unit(:, 1) = exact%total - exact%s
      unit(:, 2) = 1.0_wp
      do i = 1, exact%stations
         share(:, i) = 1 - reach_of(exact, exact%s(i))/exact%weight
      end do
      do j = 1, held%count
         pushed = held%omega2(j)*exact%mass*matmul(moved, motions(:, j))
         turned = held%omega2(j)*exact%inertia(:exact%stations)*(motions(2, j) + matmul(motions(whole + 1:, j), exact%psi))
         do i = 1, exact%stations
            behind = pushed(:exact%stations)*share(:, i)
            held%shear(i, j) = sum(behind)
            held%moment(i, j) = sum(behind*(exact%s - exact%s(i)) + turned*share(:, i))
            do k = exact%stations + 1, exact%points
               associate (arm => exact%lump_at(k - exact%stations) - exact%s(i))
                  if (arm < 0.0_wp) cycle
                  held%shear(i, j) = held%shear(i, j) + pushed(k)
                  held%moment(i, j) = held%moment(i, j) + pushed(k)*arm
               end associate
            end do
         end do
         lack = held%moment(:, j) - exact%section(of_ei, :)*matmul(motions(whole + 1:, j), exact%kappa)
         call support_forces(exact, [support%w_end, support%theta_end], unit, lack, held%moment(:, j), held%shear(:, j))
         saved = sum(exact%weight*lack**2/exact%section(of_ei, :))
         held%error(j) = 1/sqrt(1 - min(saved/held%omega2(j), 0.99_wp)) - 1
      end do
   end subroutine find_forces

   !> Adds the force and the couple of a support at the end for which least is lacking.
   pure subroutine support_forces(exact, acts, unit, lack, moment, shear)
      type(exact_type), intent(in) :: exact
      logical, intent(in) :: acts(2)
      !> Moments of a unit force and of a unit couple (stations, 2)
      real(wp), intent(in) :: unit(:, :)
      real(wp), intent(inout) :: lack(:), moment(:), shear(:)
      real(wp) :: load(2), work(2), soft(2, 2), share(exact%stations)
      integer :: i, k
      share = exact%weight/exact%section(of_ei, :)
      do i = 1, 2
         work(i) = -sum(share*unit(:, i)*lack)
         do k = 1, 2
            soft(i, k) = sum(share*unit(:, i)*unit(:, k))
         end do
      end do
      load = 0.0_wp
      if (all(acts)) then
         load = [work(1)*soft(2, 2) - work(2)*soft(1, 2), work(2)*soft(1, 1) - work(1)*soft(1, 2)] &
            & /(soft(1, 1)*soft(2, 2) - soft(1, 2)**2)
      else
         do i = 1, 2
            if (acts(i)) load(i) = work(i)/soft(i, i)
         end do
      end if
      moment = moment + matmul(unit, load)
      lack = lack + matmul(unit, load)
      shear = shear + load(1)
   end subroutine support_forces

end module limber_beam_exact_vibrations
