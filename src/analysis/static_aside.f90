!> Check of static deflections by a second scene. At each sample the scene with more of them is brought into equilibrium aside, and
!> each channel is compared with its own. Floor: analysis. Source: doc/theory, eqs. (7.49), (7.51).
!>
!>     call start_static_aside(self, scene)
!>     call compare_sample(self, scene, sample)          ! at each sample
!>     text = static_warning(self, scene, title, sample) ! at the end
module limber_analysis_static_aside
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   use limber_analysis_scene_aside, only: aside_type, build_aside, place_aside, additional_modes, add_missed
   use limber_analysis_richer_scene, only: richer_words, can_enrich, nothing_more, with_responses, with_modes, with_both
   use limber_scene_scene, only: scene_type
   use limber_model_quantities, only: quantities, is_internal_force
   use limber_model_model, only: model_type
   use limber_model_beam_segments, only: name_in_deck
   use limber_output_channel_values, only: recorder_type, new_recorder, channel_values, sample_width
   use limber_multibody_equations_of_motion, only: mechanical_energy
   use limber_multibody_equilibrium, only: linearise_balance
   use limber_multibody_driven_motion, only: driven_motion_type, new_held, balance_deflections
   use limber_multibody_kinematics, only: place_frames, move_frames
   use limber_multibody_sparse_eigenmodes, only: is_large
   use limber_multibody_layout, only: rates_of
   use limber_multibody_multiplier_system, only: update_jacobians
   use limber_multibody_system, only: system_type, workspace_type
   implicit none
   private
   public :: static_aside_type, aside_sample_type, start_static_aside, compare_sample, static_warning, &
      & least_sizes, largest_force, is_place

   !> Largest part of a channel that is not told, and above which it is only told as more than that
   real(wp), parameter :: little = 0.02_wp, beyond = 0.5_wp
   !> Parts that are nothing: of the largest channel of the same unit; of the length of the scene, and of a radian; of the largest
   !> force, and of this times the length of the scene, of forces and moments
   real(wp), parameter :: of_unit = 0.03_wp, of_place = 1.0e-6_wp, of_force = 1.0e-3_wp
   !> Modes that each body gets beside those that it has
   integer, parameter :: more = 12

   !> The scene aside, and what was compared so far
   type :: static_aside_type
      type(aside_type) :: aside
      type(recorder_type) :: recorder
      !> Of a motion that drivers give: what finds it, and its velocities and accelerations (nq of the scene aside)
      type(driven_motion_type) :: held
      real(wp), allocatable :: v(:), a(:)
      integer, allocatable :: level(:)
      integer :: extra = 0
      !> Largest differences, the largest of what bends or of the channel, and the channels at the last sample (channels); the
      !> largest force
      real(wp), allocatable :: difference(:), size(:), last(:)
      real(wp) :: force = 0.0_wp
      !> Coordinates at which the scene was assembled (nq of the scene aside)
      real(wp), allocatable :: assembled(:)
      !> Strain energy that is missed at the sample with the largest differences (bodies)
      real(wp), allocatable :: missed(:)
      !> Whether anything is compared; of a motion that drivers give whether that has begun, and its energy then: what it has more
      !> is their work
      logical :: used = .false., begun = .false.
      real(wp) :: first_energy = 0.0_wp
   end type static_aside_type

   !> A sample of the scene: time, coordinates (nq) and multipliers (nc) of an equilibrium, angles of frames (bodies) [rad],
   !> channels, steady rotation and its centre; whether drivers give the motion in place of that
   type :: aside_sample_type
      real(wp) :: t = 0.0_wp, rotation = 0.0_wp, centre(2) = 0.0_wp
      logical :: driven = .false.
      real(wp), allocatable :: q(:), lambda(:), angle(:), values(:)
   end type aside_sample_type

contains

   !> Builds the scene aside, if there are bodies with modes, and channels.
   subroutine start_static_aside(self, scene)
      type(static_aside_type), intent(inout) :: self
      type(scene_type), intent(in) :: scene
      associate (model => scene%system%model)
         allocate (self%level(size(model%bodies)), source=merge(with_both, nothing_more, can_enrich(model%bodies)))
         if (all(self%level == nothing_more) .or. size(model%channels) == 0 .or. is_large(scene%system)) return
         self%extra = additional_modes(scene%system, self%level, more)
         call build(self, scene)
         if (.not. self%used) return
         allocate (self%difference(size(model%channels)), self%size(size(model%channels)), self%missed(size(model%bodies)), &
            & self%last(size(model%channels)))
         self%difference = 0.0_wp
         self%size = 0.0_wp
         self%missed = 0.0_wp
         self%last = 0.0_wp
         allocate (self%assembled, source=straight_place(self%aside%scene%system, self%aside%scene%q))
      end associate
   end subroutine start_static_aside

   subroutine build(self, scene)
      type(static_aside_type), intent(inout) :: self
      type(scene_type), intent(in) :: scene
      call build_aside(scene, self%level, self%extra, .true., self%aside, self%used)
      if (self%used) self%used = size(self%aside%scene%system%model%channels) == size(scene%system%model%channels)
      if (.not. self%used) return
      associate (system => self%aside%scene%system)
         self%recorder = new_recorder(system, self%aside%scene%q)
         call new_held(system, self%held)
         allocate (self%v(system%layout%nq), self%a(system%layout%nq), source=0.0_wp)
      end associate
   end subroutine build

   !> Places it where the scene is, its own deflections in equilibrium.
   subroutine place(self, scene, sample, done)
      type(static_aside_type), intent(inout) :: self
      type(scene_type), intent(in) :: scene
      type(aside_sample_type), intent(in) :: sample
      !> Whether an equilibrium was found
      logical, intent(out) :: done
      call place_aside(scene, sample%t, sample%q, sample%lambda, .not. sample%driven, sample%rotation, sample%centre, self%aside, &
         & done)
      if (.not. sample%driven) return
      associate (new => self%aside%scene)
         self%held%lambda = sample%lambda
         call balance_deflections(new%system, new%work, self%held, sample%t, new%q, self%v, self%a, done)
         new%last%lambda = new%work%lambda
      end associate
   end subroutine place

   !> Compares the channels at a sample.
   subroutine compare_sample(self, scene, sample)
      type(static_aside_type), intent(inout) :: self
      type(scene_type), intent(in) :: scene
      type(aside_sample_type), intent(in) :: sample
      real(wp) :: straight(size(self%difference)), first(size(self%difference)), off(size(self%difference))
      real(wp) :: change(self%aside%scene%system%layout%nw)
      logical :: done
      call place(self, scene, sample, done)
      if (.not. done) return
      associate (new => self%aside%scene)
         ! Places and angles without deflections, in the present frames and in those of the assembly
         call take_channels(self, sample, self%assembled, first)
         call take_channels(self, sample, straight_place(new%system, new%q), straight)
         if (sample%driven) call take_work(self, sample, new%q)
         call take_channels(self, sample, new%q, self%last)
         off = abs(self%last - sample%values(:size(off)))
         self%force = max(self%force, largest_force(new%system, new%work))
         where (is_place(new%system%model))
            self%size = max(self%size, abs(self%last - straight), abs(self%last - first))
         elsewhere
            self%size = max(self%size, abs(self%last))
         end where
         if (any(off > self%difference)) then
            change = 0.0_wp
            call rates_of(new%system%layout, new%q, new%q - straight_place(new%system, new%q), change)
            self%missed = 0.0_wp
            call add_missed(scene%system, new%system, change, self%missed)
         end if
         self%difference = max(self%difference, off)
      end associate
   end subroutine compare_sample

   !> Channels of the scene aside at a place.
   subroutine take_channels(self, sample, q, channel)
      type(static_aside_type), intent(inout) :: self
      type(aside_sample_type), intent(in) :: sample
      !> (nq of it)
      real(wp), intent(in) :: q(:)
      real(wp), intent(inout) :: channel(:)
      real(wp) :: room(sample_width(self%aside%scene%system))
      associate (system => self%aside%scene%system, work => self%aside%scene%work, own => self%aside%balance, &
         & lambda => self%aside%scene%last%lambda)
         if (.not. sample%driven) then
            call linearise_balance(system, work, own, sample%t, q, lambda)
            self%v = own%v
            self%a = own%a
         end if
         call place_frames(system%model, system%layout, sample%t, q, work%kinematics)
         call move_frames(system%model, system%layout, q, self%v, work%kinematics)
         call update_jacobians(system, work)
         work%lambda = lambda
         self%recorder%turns%angle = sample%angle
         call channel_values(self%recorder, system, work, sample%t, q, self%v, self%a, room)
      end associate
      channel = room(:size(channel))
   end subroutine take_channels

   !> The work of drivers, as *INVERSE DYNAMICS finds it.
   subroutine take_work(self, sample, q)
      type(static_aside_type), intent(inout) :: self
      type(aside_sample_type), intent(in) :: sample
      !> (nq of the scene aside)
      real(wp), contiguous, intent(in) :: q(:)
      real(wp) :: kinetic, potential
      associate (system => self%aside%scene%system, work => self%aside%scene%work)
         call place_frames(system%model, system%layout, sample%t, q, work%kinematics)
         call move_frames(system%model, system%layout, q, self%v, work%kinematics)
         call mechanical_energy(system, work, q, self%v, kinetic, potential)
      end associate
      if (.not. self%begun) self%first_energy = kinetic + potential
      self%begun = .true.
      self%recorder%work = kinetic + potential - self%first_energy
   end subroutine take_work

   !> A place without deflections.
   pure function straight_place(system, q) result(place)
      type(system_type), intent(in) :: system
      !> (nq)
      real(wp), intent(in) :: q(:)
      real(wp) :: place(size(q))
      integer :: i, first
      place = q
      do i = 1, size(system%model%bodies)
         if (.not. can_enrich(system%model%bodies(i))) cycle
         first = system%layout%q(i) + 4
         place(first:first + system%layout%n(i) - 1) = 0.0_wp
      end do
   end function straight_place

   !> Whether channels are places or angles.
   pure function is_place(model)
      type(model_type), intent(in) :: model
      logical :: is_place(size(model%channels))
      integer :: i
      do i = 1, size(is_place)
         is_place(i) = any(model%channels(i)%units == [character(40) :: model%units%length, 'rad'])
      end do
   end function is_place

   !> Largest force of joints and loads on a body; a couple counts as a force on the length of the scene.
   pure real(wp) function largest_force(system, work) result(largest)
      type(system_type), intent(in) :: system
      type(workspace_type), intent(in) :: work
      real(wp) :: force(3)
      integer :: i, side, n
      largest = 0.0_wp
      do i = 1, size(system%constraints)
         associate (item => system%constraints(i)%item)
            do side = 1, 2
               if (item%bodies(side) == 0) cycle
               n = min(3, size(work%jacobians(side, i)%z, 2))
               force = 0.0_wp
               force(:n) = matmul(work%lambda(item%first:item%first + item%rows - 1), work%jacobians(side, i)%z(:item%rows, :n))
               largest = max(largest, size_of(force))
            end do
         end associate
      end do
      do i = 1, size(system%loads)
         associate (item => system%loads(i)%item, whole => work%loads(i)%force)
            do side = 1, size(item%rates)
               n = min(3, item%rates(side), size(whole) - item%offsets(side))
               force = 0.0_wp
               force(:n) = whole(item%offsets(side) + 1:item%offsets(side) + n)
               largest = max(largest, size_of(force))
            end do
         end associate
      end do

   contains

      pure real(wp) function size_of(force)
         real(wp), intent(in) :: force(3)
         size_of = max(norm2(force(1:2)), abs(force(3))/system%model%length)
      end function size_of

   end function largest_force

   !> The channel that errs most, the body that misses most, and a remedy, tried at the last sample; empty if all are right.
   function static_warning(self, scene, title, sample) result(text)
      type(static_aside_type), intent(in) :: self
      type(scene_type), intent(in) :: scene
      !> Keyword and name of the analysis
      character(*), intent(in) :: title
      !> The last one
      type(aside_sample_type), intent(in) :: sample
      character(:), allocatable :: text
      real(wp), allocatable :: least(:), error(:)
      integer :: worst, body
      text = ''
      if (.not. self%used) return
      allocate (least, source=least_sizes(self%size, self%force, scene%system%model))
      allocate (error, source=self%difference/least)
      worst = maxloc(error, dim=1)
      if (.not. error(worst) > little) return
      body = maxloc(self%missed, dim=1, mask=can_enrich(scene%system%model%bodies))
      associate (model => scene%system%model)
         text = "warning: channel '"//model%channels(worst)%name//"' of "//title
         if (count(error > little) > 1) text = text//' (and '//as_text(count(error > little) - 1)//' more)'
         text = text//' errs by '
         if (error(worst) > beyond) text = text//'more than '
         text = text//'about '//as_text(100*min(error(worst), beyond), 2)//' %: '// &
            & trim(merge('frame', 'beam ', model%bodies(body)%is_frame))//" '"//name_in_deck(model, body)// &
            & "' cannot take this shape with its "//as_text(model%bodies(body)%reduced%n)//' coordinates; use '// &
            & remedy()//newline
      end associate

   contains

      !> The first that tells the same at the last sample.
      function remedy() result(words)
         character(:), allocatable :: words
         integer :: choice
         do choice = with_responses, with_modes
            words = richer_words(scene, body, choice, self%extra)
            if (words == '') cycle
            if (cures(self, scene, sample, body, choice, least)) return
         end do
         words = richer_words(scene, body, with_both, self%extra)
      end function remedy

   end function static_warning

   !> Whether a remedy makes all channels at the last sample what the richer scene makes of them.
   logical function cures(self, scene, sample, body, choice, least)
      type(static_aside_type), intent(in) :: self
      type(scene_type), intent(in) :: scene
      !> The last one
      type(aside_sample_type), intent(in) :: sample
      !> The body that gets the remedy, and which
      integer, intent(in) :: body, choice
      !> What differences are compared with (channels)
      real(wp), intent(in) :: least(:)
      type(static_aside_type), allocatable :: trial
      real(wp) :: channel(size(least))
      allocate (trial)
      trial%extra = self%extra
      allocate (trial%level, source=self%level)
      trial%level(body) = choice
      call build(trial, scene)
      cures = trial%used
      if (.not. cures) return
      call place(trial, scene, sample, cures)
      if (.not. cures) return
      call take_channels(trial, sample, trial%aside%scene%q, channel)
      cures = all(abs(channel - self%last) <= little*least)
   end function cures

   !> What differences are compared with: the size of the channel, parts of the largest of its unit, and what is nothing (channels),
   !> eq. (7.51).
   pure function least_sizes(sizes, forces, model) result(least)
      !> Of the channels (channels); largest force
      real(wp), intent(in) :: sizes(:), forces
      type(model_type), intent(in) :: model
      real(wp) :: least(size(sizes)), force, unit
      logical :: place(size(sizes))
      integer :: i, k
      place = is_place(model)
      force = forces
      do i = 1, size(least)
         unit = force_unit(model, i)
         if (unit > 0.0_wp) force = max(force, sizes(i)/unit)
      end do
      do i = 1, size(least)
         least(i) = max(sizes(i), of_force*force*force_unit(model, i), tiny(force))
         do k = 1, size(least)
            if (are_alike(model, i, k)) least(i) = max(least(i), of_unit*sizes(k))
         end do
         if (place(i)) least(i) = max(least(i), of_place*merge(1.0_wp, model%length, model%channels(i)%units == 'rad'))
      end do
   end function least_sizes

   !> Whether a channel is measured by another one: of one unit, and both or neither the same internal force. Bending moments of a
   !> lattice are small beside the couples of its joints, and shear forces beside its axial ones; they stress it all the same.
   pure logical function are_alike(model, i, k)
      type(model_type), intent(in) :: model
      integer, intent(in) :: i, k
      are_alike = model%channels(i)%units == model%channels(k)%units .and. internal(i) == internal(k)

   contains

      !> Kind of a channel that is an internal force; of any other 0.
      pure integer function internal(channel)
         integer, intent(in) :: channel
         internal = 0
         associate (quantities => model%channels(channel)%quantities)
            if (size(quantities) /= 1) return
            if (is_internal_force(quantities(1)%kind)) internal = quantities(1)%kind
         end associate
      end function internal

   end function are_alike

   !> What a unit force makes of a channel of a force, moment or stress, by its size alone; 0: it is none.
   pure real(wp) function force_unit(model, channel) result(unit)
      type(model_type), intent(in) :: model
      integer, intent(in) :: channel
      integer :: k, power
      unit = 0.0_wp
      do k = 1, size(model%channels(channel)%quantities)
         ! A parameter or the like has no kind
         if (model%channels(channel)%quantities(k)%kind == 0) cycle
         associate (dimension => quantities(model%channels(channel)%quantities(k)%kind)%dimension)
            if (any(dimension(2:3) /= [-2, 1])) cycle
            power = dimension(1) - 1
         end associate
         unit = model%length**max(0, power)
         if (power > 0 .and. is_internal_force(model%channels(channel)%quantities(k)%kind)) &
            & unit = member_length(model, model%channels(channel)%quantities(k)%of)**power
         if (power < 0) unit = 1/largest_area(model)
      end do
   end function force_unit

   !> Length of the beam or member that a point lies on.
   pure real(wp) function member_length(model, point) result(length)
      type(model_type), intent(in) :: model
      integer, intent(in) :: point
      associate (own => model%points(point), body => model%bodies(model%points(point)%body))
         length = body%beam%length
         if (body%is_frame) length = sum(body%mesh%length, mask=body%mesh%member == own%member)
      end associate
   end function member_length

   pure real(wp) function largest_area(model) result(area)
      type(model_type), intent(in) :: model
      integer :: i
      area = tiny(area)
      do i = 1, size(model%bodies)
         if (allocated(model%bodies(i)%strength)) area = max(area, maxval(model%bodies(i)%strength(1, :)))
      end do
   end function largest_area

end module limber_analysis_static_aside
