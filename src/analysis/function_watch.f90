!> Whether the functions of exact beams are enough: bending moment and axial force that equilibrium asks for, along the beam, against
!> those that the functions make. What differs is what they leave out, and its elastic energy the size of that. Floor: analysis.
!> Source: doc/theory, eqs. (X16), (X17).
module limber_analysis_function_watch
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_text, only: as_text
   use limber_flex_exact_profile, only: of_ei, of_ea
   use limber_flex_recovery, only: recovery_type
   use limber_model_scene, only: model_type
   use limber_model_stresses, only: recover_stations
   use limber_output_internal_forces, only: effort_type, start_effort, gather_exact
   use limber_system_system, only: system_type, workspace_type
   implicit none
   private
   public :: function_watch_type, start_functions, observe_functions, join_functions, function_warnings

   !> Parts of the energy that may be left out: of that of bending by the angle, of all by the strain
   real(wp), parameter :: allowed(2) = [0.006_wp, 0.006_wp]
   !> Mean slope and strain that are too small to count
   real(wp), parameter :: least(2) = [1.0e-5_wp, 1.0e-4_wp]

   !> What is left out of one beam
   type :: beam_watch_type
      !> Index of the body
      integer :: body = 0
      !> Its stations as sections, and what acts there
      type(recovery_type) :: recovery
      type(effort_type) :: effort
      !> Largest energies, of bending and of all; largest ones that are left out, of bending and of stretch, and when
      real(wp) :: energy(2) = 0.0_wp, left_out(2) = 0.0_wp, when(2) = 0.0_wp
      !> Largest mean slope and strain that are left out
      real(wp) :: size(2) = 0.0_wp
   end type beam_watch_type

   !> All exact beams
   type :: function_watch_type
      type(beam_watch_type), allocatable :: beams(:)
   contains
      procedure :: exchange
   end type function_watch_type

contains

   !> Begins to watch.
   subroutine start_functions(self, system)
      type(function_watch_type), intent(out) :: self
      type(system_type), intent(in) :: system
      integer :: i, k
      allocate (self%beams(count(system%model%bodies%reduced%is_exact)))
      k = 0
      do i = 1, size(system%model%bodies)
         if (.not. system%model%bodies(i)%reduced%is_exact) cycle
         k = k + 1
         self%beams(k)%body = i
         call recover_stations(system%model, i, self%beams(k)%recovery)
         call start_effort(self%beams(k)%effort, system, i, self%beams(k)%recovery)
      end do
   end subroutine start_functions

   !> Takes in a state. Kinematics are placed and moved there; Jacobians and multipliers are those of the state.
   subroutine observe_functions(self, system, work, t, q, v, a)
      type(function_watch_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      !> Time; coordinates, velocities, accelerations (nq)
      real(wp), intent(in) :: t, q(:), v(:), a(:)
      integer :: i, first, last
      do i = 1, size(self%beams)
         associate (beam => self%beams(i))
            call gather_exact(beam%effort, system, work, beam%body, beam%recovery, q, v, a)
            first = system%layout%q(beam%body) + 4
            last = first - 1 + system%layout%n(beam%body)
            call compare(beam, system, t, q(first:last), v(first:last))
         end associate
      end do
   end subroutine observe_functions

   !> What equilibrium asks for less what the functions make, eq. (X16).
   subroutine compare(beam, system, t, eta, rate)
      type(beam_watch_type), intent(inout) :: beam
      type(system_type), intent(in) :: system
      !> Time; coordinates and their rates (n)
      real(wp), intent(in) :: t, eta(:), rate(:)
      real(wp) :: strained(size(eta)), energy(2), left_out(2), parts(2), own
      integer :: k, kind
      associate (body => system%model%bodies(beam%body), exact => system%model%bodies(beam%body)%reduced%exact)
         ! Damping makes moments, too
         strained = eta - exact%rest
         if (allocated(body%reduced%damping)) then
            if (size(body%reduced%damping, 1) == size(eta)) strained = strained &
            & + matmul(body%reduced%damping, rate)/body%reduced%omega2
         end if
         energy = 0.0_wp
         left_out = 0.0_wp
         do k = 1, exact%stations
            own = dot_product(exact%kappa(:, k), strained(:exact%angles))
            parts(1) = beam%effort%exact(3, k)/exact%section(of_ei, k) - own
            energy = energy + 0.5_wp*exact%weight(k)*exact%section(of_ei, k)*own**2
            own = dot_product(exact%chi(1, :, k), strained(exact%angles + 1:))
            parts(2) = beam%effort%exact(1, k)/exact%section(of_ea, k) - own
            energy(2) = energy(2) + 0.5_wp*exact%weight(k)*exact%section(of_ea, k)*own**2
            left_out = left_out + 0.5_wp*exact%weight(k)*[exact%section(of_ei, k), exact%section(of_ea, k)]*parts**2
         end do
         energy = energy + [left_out(1), sum(left_out)]
         beam%energy = max(beam%energy, energy)
         do kind = 1, 2
            if (left_out(kind) <= beam%left_out(kind)) cycle
            beam%left_out(kind) = left_out(kind)
            beam%when(kind) = t
            beam%size(kind) = sqrt(2*left_out(kind)/merge(exact%section(of_ei, 1)/exact%total, &
               & exact%section(of_ea, 1)*exact%total, kind == 1))
         end do
      end associate
   end subroutine compare

   !> Joins what an analysis has seen to that of those before.
   subroutine join_functions(part, whole)
      type(function_watch_type), intent(in) :: part
      type(function_watch_type), intent(inout) :: whole
      integer :: i, kind
      do i = 1, size(whole%beams)
         associate (beam => whole%beams(i), own => part%beams(i))
            beam%energy = max(beam%energy, own%energy)
            do kind = 1, 2
               if (own%left_out(kind) <= beam%left_out(kind)) cycle
               beam%left_out(kind) = own%left_out(kind)
               beam%when(kind) = own%when(kind)
               beam%size(kind) = own%size(kind)
            end do
         end associate
      end do
   end subroutine join_functions

   !> A warning for each beam that has too few functions, of the angle and of the strain.
   function function_warnings(self, model, times) result(text)
      type(function_watch_type), intent(in) :: self
      type(model_type), intent(in) :: model
      !> How many times beyond its limit the energy left out must be
      real(wp), intent(in) :: times
      character(:), allocatable :: text
      integer :: i
      real(wp) :: part(2)
      text = ''
      do i = 1, size(self%beams)
         associate (beam => self%beams(i), body => model%bodies(self%beams(i)%body))
            part = 0.0_wp
            where (beam%energy > 0.0_wp) part = beam%left_out/max(beam%energy, tiny(part))
            if (part(1) > times*allowed(1) .and. beam%size(1) > least(1)) call tell('angle', 1, 'FUNCTIONS=', &
               & 2*body%choice%exact%angles)
            if (part(2) > times*allowed(2) .and. beam%size(2) > least(2)) call tell('strain', 2, 'STRAIN FUNCTIONS=', &
               & max(3, 2*body%choice%exact%strains))
         end associate
      end do

   contains

      !> One of them.
      subroutine tell(field, kind, option, better)
         character(*), intent(in) :: field, option
         integer, intent(in) :: kind, better
         text = text//"warning: beam '"//model%bodies(self%beams(i)%body)%name//"' has too few functions of the "//field// &
            & ': they leave out '//as_text(100*part(kind), 2)//' % of its elastic energy at t = '// &
            & as_text(self%beams(i)%when(kind), 4)//', so that its deflection may err by up to about '// &
            & as_text(50*sqrt(part(kind)), 2)//' %; use '//option//as_text(better)//new_line('a')
      end subroutine tell

   end function function_warnings

   !> Saves or restores it.
   subroutine exchange(self, snapshot)
      class(function_watch_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      integer :: i
      do i = 1, size(self%beams)
         call snapshot%exchange('energy_1', self%beams(i)%energy(1))
         call snapshot%exchange('energy_2', self%beams(i)%energy(2))
         call snapshot%exchange('left_out_1', self%beams(i)%left_out(1))
         call snapshot%exchange('left_out_2', self%beams(i)%left_out(2))
         call snapshot%exchange('when_1', self%beams(i)%when(1))
         call snapshot%exchange('when_2', self%beams(i)%when(2))
         call snapshot%exchange('size_1', self%beams(i)%size(1))
         call snapshot%exchange('size_2', self%beams(i)%size(2))
      end do
   end subroutine exchange

end module limber_analysis_function_watch
